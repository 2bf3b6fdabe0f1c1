// SPDX-License-Identifier: Apache-2.0
#include "irt/shade/light_path.h"

#include <algorithm>

namespace irt::shade {

namespace {

/// Whether a light's record is of the light called `label`, or of one below that path. (A dome's
/// records are named after it: /Dome#0003.)
bool belongs(const std::string& record, const std::string& label) {
    const std::string light = record.substr(0, record.find('#'));
    if (label.front() != '/') return light.substr(light.rfind('/') + 1) == label;
    return light.compare(0, label.size(), label) == 0 &&
           (light.size() == label.size() || light[label.size()] == '/');
}

}  // namespace

std::vector<ResolvedPart> resolved(const std::vector<BeautyPart>& parts, const Scene& scene) {
    std::vector<ResolvedPart> result;
    for (const BeautyPart& part : parts) {
        ResolvedPart& out = result.emplace_back();
        out.events = part.events;
        out.columns.push_back(part.emission);
        for (const LightSlot& light : scene.lights())
            out.columns.push_back(
                !part.lights ||
                std::any_of(part.lights->begin(), part.lights->end(),
                            [&](const std::string& path) { return belongs(light.path, path); }));
    }
    return result;
}

}  // namespace irt::shade
