// SPDX-License-Identifier: Apache-2.0
// The one place that includes Embree, and where its versions 3 and 4 differ. Internal to trace/.
#pragma once

#include <stdexcept>
#include <string>

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

namespace irt::trace::embree {

#if RTC_VERSION_MAJOR >= 4
using Context = RTCRayQueryContext;
inline void init(Context& context) { rtcInitRayQueryContext(&context); }
inline void intersect(RTCScene scene, Context& context, RTCRayHit& ray) {
    RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.context = &context;
    rtcIntersect1(scene, &ray, &arguments);
}
inline void occluded(RTCScene scene, Context& context, RTCRay& ray) {
    RTCOccludedArguments arguments;
    rtcInitOccludedArguments(&arguments);
    arguments.context = &context;
    rtcOccluded1(scene, &ray, &arguments);
}
#else
using Context = RTCIntersectContext;
inline void init(Context& context) { rtcInitIntersectContext(&context); }
inline void intersect(RTCScene scene, Context& context, RTCRayHit& ray) {
    rtcIntersect1(scene, &context, &ray);
}
inline void occluded(RTCScene scene, Context& context, RTCRay& ray) {
    rtcOccluded1(scene, &context, &ray);
}
#endif

/// Throws std::runtime_error if `device` has an error pending.
inline void check(RTCDevice device, const char* what) {
    const RTCError error = rtcGetDeviceError(device);
    if (error != RTC_ERROR_NONE)
        throw std::runtime_error(std::string("Embree failed to ") + what + " (error " +
                                 std::to_string(static_cast<int>(error)) + ")");
}

/// A device of one instruction set; `threads` 0 means all. Throws std::invalid_argument if the name
/// is unknown or this processor lacks it.
RTCDevice make_device(const std::string& isa, int threads);

}  // namespace irt::trace::embree
