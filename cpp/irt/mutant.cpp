// SPDX-License-Identifier: Apache-2.0
#include "irt/mutant.h"

#ifdef IRT_MUTANTS

#include <algorithm>
#include <cstdlib>
#include <stdexcept>

namespace irt {

namespace {

/// Which of `names` an environment variable asks for, counted from 1; 0: none. A name that is not
/// among them would make a test pass for nothing.
int asked_for(const char* variable, const std::vector<std::string>& names) {
    const char* value = std::getenv(variable);
    if (!value || !*value) return 0;
    const auto found = std::find(names.begin(), names.end(), value);
    if (found == names.end())
        throw std::invalid_argument(std::string(variable) + " names nothing: " + value);
    return static_cast<int>(found - names.begin()) + 1;
}

}  // namespace

const std::vector<std::string>& mutant_names() {
    static const std::vector<std::string> names{
        "dropped_voxel",         "no_dilation",          "ghost_ignored",   "outside_ignored",
        "stale_record",          "stale_epoch",          "blocker_kept",    "mask_bit_dropped",
        "union_without_shadows", "cut_off_not_rewalked", "branch_ray_kept", "node_reused",
        "tints_in_order",        "search_ends_short",    "no_box_pad",      "energy_rescaled",
        "tint_departed_ignored", "still_tint_ignored",   "rebound_ignored", "future_ignored",
        "footprint_restarted",   "tint_graph_ignored",   "lights_by_place"};
    return names;
}

const std::vector<std::string>& structure_names() {
    static const std::vector<std::string> names{
        "path_flags",     "cumulative_flags", "intersection_history", "material_mask",
        "shadow_records", "blocker_names",    "dynamic_set",          "segment_test",
        "region_bounds",  "light_columns"};
    return names;
}

bool mutated(Mutant mutant) {
    static const int on = asked_for("IRT_MUTANT", mutant_names());
    return on != 0 && on == static_cast<int>(mutant);
}

bool without(Structure structure) {
    static const int off = asked_for("IRT_WITHOUT", structure_names());
    return off != 0 && off == static_cast<int>(structure);
}

}  // namespace irt

#endif
