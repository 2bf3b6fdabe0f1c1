// SPDX-License-Identifier: Apache-2.0
// Whether two records are the same to the bit; only then is an edit no change.
#pragma once

#include "irt/scene/records.h"

namespace irt {

bool same(const Quadric& a, const Quadric& b);
bool same(const Primvars& a, const Primvars& b);
bool same(const Mesh& a, const Mesh& b);
/// Whether rays meet the two alike, in position and geometric normal: they may differ in all that
/// shading alone reads.
bool same_hits(const Mesh& a, const Mesh& b);
bool same(const Spheres& a, const Spheres& b);
bool same(const Curves& a, const Curves& b);
bool same(const Prototype& a, const Prototype& b);
/// Whether entry `i` of `a` has the primvars that entry `j` of `b` has.
bool same_primvars(const InstanceArray& a, std::size_t i, const InstanceArray& b, std::size_t j);
bool same(const Geometry& a, const Geometry& b);
bool same(const Material& a, const Material& b);
/// Whether both stop the same share of a shadow ray everywhere; false where that is hard to tell.
bool same_tint(const Material& a, const Material& b);
bool same(const Light& a, const Light& b);
/// Whether the two are alike in all but energy.
bool same_but_energy(const Light& a, const Light& b);
/// Whether rays that meet nothing see the two alike, energy apart.
bool same_sky(const Light& a, const Light& b);
/// Whether surfaces that both light respond to them alike, energy apart, where the same shadows
/// fall.
bool same_response(const Light& a, const Light& b);
/// Whether the two cast the same shadow rays from surfaces that both light, what both let cast
/// shadows stops the same share of those, and the two are seen by the same rays.
bool same_rays(const Light& a, const Light& b);
bool same(const Camera& a, const Camera& b);

}  // namespace irt
