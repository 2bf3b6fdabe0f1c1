// SPDX-License-Identifier: Apache-2.0
#include "delegate/primvars.h"

#include <algorithm>
#include <cmath>

#include "pxr/base/gf/vec2d.h"
#include "pxr/base/gf/vec2f.h"
#include "pxr/base/gf/vec2h.h"
#include "pxr/base/gf/vec2i.h"
#include "pxr/base/gf/vec3d.h"
#include "pxr/base/gf/vec3f.h"
#include "pxr/base/gf/vec3h.h"
#include "pxr/base/gf/vec3i.h"
#include "pxr/base/gf/vec4d.h"
#include "pxr/base/gf/vec4f.h"
#include "pxr/base/gf/vec4h.h"
#include "pxr/base/gf/vec4i.h"
#include "pxr/base/vt/array.h"
#include "pxr/imaging/hd/extComputationUtils.h"

PXR_NAMESPACE_OPEN_SCOPE

namespace {

template <class T>
void Append(const T& value, std::vector<float>& out) {
    if constexpr (GfIsGfVec<T>::value)
        for (std::size_t c = 0; c < T::dimension; ++c) out.push_back(static_cast<float>(value[c]));
    else
        out.push_back(static_cast<float>(value));
}

template <class T>
int Width() {
    if constexpr (GfIsGfVec<T>::value) return static_cast<int>(T::dimension);
    return 1;
}

template <class T>
bool ReadAs(const VtValue& value, irt::Primvar& out) {
    if (value.IsHolding<T>()) {
        out.width = Width<T>();
        Append(value.UncheckedGet<T>(), out.values);
        return true;
    }
    if (!value.IsHolding<VtArray<T>>()) return false;
    out.width = Width<T>();
    for (const T& element : value.UncheckedGet<VtArray<T>>()) Append(element, out.values);
    return true;
}

template <class... T>
bool ReadAsOneOf(const VtValue& value, irt::Primvar& out) {
    return (ReadAs<T>(value, out) || ...);
}

bool Read(const VtValue& value, irt::Primvar& out) {
    return ReadAsOneOf<float, GfVec2f, GfVec3f, GfVec4f, double, GfVec2d, GfVec3d, GfVec4d, GfHalf,
                       GfVec2h, GfVec3h, GfVec4h, int, GfVec2i, GfVec3i, GfVec4i, bool,
                       unsigned int, unsigned char>(value, out);
}

std::string Fault(const irt::Primvar& primvar) {
    if (!std::all_of(primvar.values.begin(), primvar.values.end(),
                     [](float v) { return std::isfinite(v); }))
        return "it holds a NaN, or a number beyond single precision";
    const auto count = static_cast<std::int64_t>(primvar.values.size()) / primvar.width;
    for (const std::int32_t index : primvar.indices)
        if (index < 0 || index >= count)
            return "index " + std::to_string(index) + " names none of its " +
                   std::to_string(count) + " values";
    return {};
}

void Warn(const SdfPath& id, const std::string& name, const std::string& fault) {
    TF_WARN("<%s>: the primvar %s is not used: %s", id.GetText(), name.c_str(), fault.c_str());
}

}  // namespace

irt::Interpolation HdIrtInterpolation(HdInterpolation interpolation) {
    switch (interpolation) {
        case HdInterpolationConstant:
            return irt::Interpolation::Constant;
        case HdInterpolationUniform:
            return irt::Interpolation::Uniform;
        case HdInterpolationVarying:
            return irt::Interpolation::Varying;
        case HdInterpolationVertex:
            return irt::Interpolation::Vertex;
        case HdInterpolationFaceVarying:
            return irt::Interpolation::FaceVarying;
        default:
            return irt::Interpolation::None;
    }
}

std::size_t HdIrtElements(const irt::Primvar& primvar) {
    return primvar.indices.empty() ? primvar.values.size() / static_cast<std::size_t>(primvar.width)
                                   : primvar.indices.size();
}

std::optional<irt::Primvar> HdIrtReadPrimvar(HdSceneDelegate& delegate, const SdfPath& id,
                                             const std::string& name) {
    for (int i = 0; i < HdInterpolationCount; ++i) {
        const auto interpolation = static_cast<HdInterpolation>(i);
        if (interpolation == HdInterpolationInstance) continue;
        for (const HdPrimvarDescriptor& found : delegate.GetPrimvarDescriptors(id, interpolation)) {
            if (found.name != name) continue;
            irt::Primvar primvar;
            primvar.name = name;
            primvar.interpolation = HdIrtInterpolation(interpolation);
            VtIntArray indices;
            const VtValue value = found.indexed
                                      ? delegate.GetIndexedPrimvar(id, found.name, &indices)
                                      : delegate.Get(id, found.name);
            if (value.IsEmpty()) return std::nullopt;
            if (!Read(value, primvar)) {
                Warn(id, name, "its type is " + value.GetTypeName() + "; expected 1 to 4 numbers");
                return std::nullopt;
            }
            primvar.indices.assign(indices.cbegin(), indices.cend());
            const std::string fault = Fault(primvar);
            if (fault.empty()) return primvar;
            Warn(id, name, fault);
            return std::nullopt;
        }
    }
    return std::nullopt;
}

irt::Primvars HdIrtReadPrimvars(HdSceneDelegate& delegate, const SdfPath& id,
                                const std::set<std::string>& wanted,
                                const HdIrtElementCount& count) {
    irt::Primvars usable;
    for (const std::string& name : wanted) {
        std::optional<irt::Primvar> primvar = HdIrtReadPrimvar(delegate, id, name);
        if (!primvar) continue;
        const std::size_t expected = count(primvar->interpolation), there = HdIrtElements(*primvar);
        if (expected == there)
            usable.push_back(std::move(*primvar));
        else
            Warn(id, name,
                 "there are " + std::to_string(there) + " elements; expected " +
                     std::to_string(expected));
    }
    return usable;
}

irt::Primvars HdIrtConstantPrimvars(HdSceneDelegate& delegate, const SdfPath& id,
                                    const std::set<std::string>& wanted) {
    irt::Primvars usable;
    for (const std::string& name : wanted) {
        std::optional<irt::Primvar> primvar = HdIrtReadPrimvar(delegate, id, name);
        if (!primvar) continue;
        if (HdIrtElements(*primvar) != 1) {
            Warn(id, name,
                 "it has " + std::to_string(HdIrtElements(*primvar)) +
                     " elements; expected one, the shape having no vertices");
            continue;
        }
        if (!primvar->indices.empty()) {
            const auto first = primvar->values.begin() +
                               static_cast<std::ptrdiff_t>(primvar->indices[0]) * primvar->width;
            primvar->values = std::vector<float>(first, first + primvar->width);
            primvar->indices.clear();
        }
        primvar->interpolation = irt::Interpolation::Constant;
        usable.push_back(std::move(*primvar));
    }
    return usable;
}

VtValue HdIrtComputedPrimvar(HdSceneDelegate& delegate, const SdfPath& id, const TfToken& name) {
    for (const HdExtComputationPrimvarDescriptor& found :
         delegate.GetExtComputationPrimvarDescriptors(id, HdInterpolationVertex)) {
        if (found.name != name) continue;
        const HdExtComputationUtils::ValueStore values =
            HdExtComputationUtils::GetComputedPrimvarValues({found}, &delegate);
        const auto value = values.find(name);
        if (value != values.end()) return value->second;
    }
    return delegate.Get(id, name);
}

PXR_NAMESPACE_CLOSE_SCOPE
