// SPDX-License-Identifier: Apache-2.0
// The ray the judges read: double precision, in the space of the geometry judged.
#pragma once

#include <algorithm>
#include <cmath>

#include "irt/math/vec.h"
#include "irt/trace/ray.h"

namespace irt::trace {

/// A ray in double, with the shear of Woop, Benthin and Wald ("Watertight Ray/Triangle
/// Intersection", JCGT 2(1), 2013) that makes it the +z axis. `t` is the authored ray's, in
/// whatever space this is: transforms are affine and do not touch it.
struct JudgeRay {
    double origin[3];
    double direction[3];
    double t_max;
    int kx, ky, kz;     ///< kz: the axis of the largest component; kx, ky keep the handedness
    double sx, sy, sz;  ///< the shear; sz also scales depth to t
};

/// Fills kx, ky, kz, sx, sy, sz from `direction`, a pure function of it.
inline void set_shear(JudgeRay& ray) {
    const double x = std::fabs(ray.direction[0]), y = std::fabs(ray.direction[1]),
                 z = std::fabs(ray.direction[2]);
    // Arithmetic instead of branches: rays of a bounce take every axis alike.
    const int not_x = x <= std::max(y, z) ? 1 : 0, kz = not_x * (1 + (y <= z ? 1 : 0));
    const int next = (0x021 >> (4 * kz)) & 3, last = (0x102 >> (4 * kz)) & 3;
    const int swap = ray.direction[kz] < 0 ? next ^ last : 0;
    ray.kz = kz;
    ray.kx = next ^ swap;
    ray.ky = last ^ swap;
    ray.sz = 1 / ray.direction[kz];
    ray.sx = ray.direction[ray.kx] * ray.sz;
    ray.sy = ray.direction[ray.ky] * ray.sz;
}

/// `ray` for the judges, in the space it is given in.
inline JudgeRay judge_ray(const Ray& ray) {
    JudgeRay j;
    for (int a = 0; a < 3; ++a) {
        j.origin[a] = static_cast<double>(ray.origin[a]);
        j.direction[a] = static_cast<double>(ray.direction[a]);
    }
    j.t_max = static_cast<double>(ray.t_max);
    set_shear(j);
    return j;
}

/// Makes `j` the ray `ray`, given in space b, in space a. In place: a copy as wide as registers, of
/// what was just written number by number, would wait for the writes to leave for the cache.
inline void transform_ray(const M44d& a_from_b, const JudgeRay& ray, JudgeRay& j) {
    const V3d origin(ray.origin[0], ray.origin[1], ray.origin[2]);
    const V3d direction(ray.direction[0], ray.direction[1], ray.direction[2]);
    const V3d o = transform_point(a_from_b, origin), d = transform_direction(a_from_b, direction);
    for (int a = 0; a < 3; ++a) {
        j.origin[a] = o[a];
        j.direction[a] = d[a];
    }
    j.t_max = ray.t_max;
    set_shear(j);
}

}  // namespace irt::trace
