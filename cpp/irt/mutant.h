// SPDX-License-Identifier: Apache-2.0
// Faults and missing structures that the test build (CMake option IRT_MUTANTS) switches on, one at
// a time and for the life of a process: faults prove that the tests can fail, and the structures,
// taken away, show what each is worth (docs/measurements.md, "Ablation"). In the product every
// switch is a constant, and costs nothing.
#pragma once

#include <string>
#include <vector>

namespace irt {

/// What a careless hand might get wrong. Named by the environment's IRT_MUTANT.
enum class Mutant {
    none,
    dropped_voxel,          ///< footprints lack a voxel, and its box: its neighbours would hide it
    no_dilation,            ///< footprints and hulls end where arithmetic says
    ghost_ignored,          ///< an object flags where it is, not where it was
    outside_ignored,        ///< what changes outside the grid flags nothing
    stale_record,           ///< a hit kept behind counts though its object has changed since
    stale_epoch,            ///< ... and though the dynamic set has been folded since
    blocker_kept,           ///< a shadow stays though its blocker changed
    mask_bit_dropped,       ///< one bit of the changed materials' mask is lost
    union_without_shadows,  ///< a shadow ray's change does not climb to its root
    cut_off_not_rewalked,   ///< a branch is kept though other branches are cut below it now
    branch_ray_kept,        ///< ... and though its own ray is another now
    node_reused,            ///< a branch that was freed is still linked
    tints_in_order,         ///< tints add with a rounding that depends on their order
    search_ends_short,      ///< Embree's search ends a little before the best hit
    no_box_pad,             ///< boxes handed to Embree are as tight as single precision allows
    energy_rescaled,        ///< a light's share is rescaled, not its response summed anew
    tint_departed_ignored,  ///< glass that left is taken for nothing
    still_tint_ignored,     ///< glass that turned darker in its place is taken for nothing
    rebound_ignored,        ///< a mask bit of another material does not shade a rebound object
    future_ignored,         ///< what a shot will move is taken to stay
    footprint_restarted,    ///< a spawned ray's cone is taken to begin at its origin
    tint_graph_ignored,     ///< glass whose tint is textured is taken to tint as it did
    lights_by_place,        ///< lights are known again by their place, not by their path
};

/// Structures of the paper, and of ours, taken away. Named by the environment's IRT_WITHOUT. The
/// film stays what it is.
enum class Structure {
    none,
    path_flags,            ///< the hash table's flags: every ray is tested
    cumulative_flags,      ///< every tree is walked
    intersection_history,  ///< no hit behind the visible one is kept
    material_mask,         ///< a changed material shades every point
    shadow_records,        ///< every shadow ray is traced
    blocker_names,         ///< a shadow record does not know what blocks it
    dynamic_set,           ///< every query searches the whole scene
    segment_test,          ///< flagged segments are not tested against the movers' boxes
    region_bounds,         ///< footprints are whole voxels
    light_columns,         ///< a light's new energy is a new light
};

#ifdef IRT_MUTANTS
[[nodiscard]] bool mutated(Mutant mutant);
[[nodiscard]] bool without(Structure structure);
/// All names, but for `none`.
[[nodiscard]] const std::vector<std::string>& mutant_names();
[[nodiscard]] const std::vector<std::string>& structure_names();
#else
[[nodiscard]] constexpr bool mutated(Mutant) { return false; }
[[nodiscard]] constexpr bool without(Structure) { return false; }
#endif

}  // namespace irt
