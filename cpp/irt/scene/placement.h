// SPDX-License-Identifier: Apache-2.0
// Where instances lie: from the record of an entry to its matrices. Inverses are made when a ray
// asks, a pure function of the record, for a million of them would take as much memory as the
// records.
#pragma once

#include "irt/math/vec.h"
#include "irt/scene/records.h"

namespace irt {

[[nodiscard]] inline M44d matrix_of(const Affine& rows) {
    return {rows[0], rows[1], rows[2], 0, rows[3], rows[4],  rows[5],  0,
            rows[6], rows[7], rows[8], 0, rows[9], rows[10], rows[11], 1};
}

/// first * then, both affine: `rows` are those of `first`.
[[nodiscard]] inline M44d placed(const Affine& rows, const M44d& then) {
    M44d m;
    for (int i = 0; i < 4; ++i) {
        const double* row = &rows[static_cast<std::size_t>(3 * i)];
        for (int j = 0; j < 3; ++j) {
            m[i][j] = row[0] * then[0][j] + row[1] * then[1][j] + row[2] * then[2][j];
            if (i == 3) m[i][j] += then[3][j];
        }
        m[i][3] = i == 3 ? 1 : 0;
    }
    return m;
}

/// The adjugate of the 3x3 part of `m`, its translation left out, and the determinant.
struct Adjugate {
    double entries[3][3];
    double determinant;
};
[[nodiscard]] inline Adjugate adjugate_of(const M44d& m) {
    Adjugate out;
    for (int i = 0; i < 3; ++i) {
        const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
        for (int j = 0; j < 3; ++j) {
            const int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
            out.entries[j][i] = m[i1][j1] * m[i2][j2] - m[i1][j2] * m[i2][j1];
        }
    }
    out.determinant =
        m[0][0] * out.entries[0][0] + m[0][1] * out.entries[1][0] + m[0][2] * out.entries[2][0];
    return out;
}

/// The inverse of an affine matrix that has one (checked_inverse says which do). Its last column is
/// taken for 0 0 0 1.
[[nodiscard]] inline M44d inverse_of(const M44d& m) {
    const Adjugate adjugate = adjugate_of(m);
    M44d inverse;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) inverse[i][j] = adjugate.entries[i][j] / adjugate.determinant;
    const V3d t = transform_direction(inverse, {m[3][0], m[3][1], m[3][2]});
    for (int j = 0; j < 3; ++j) {
        inverse[3][j] = -t[j];
        inverse[j][3] = 0;
    }
    inverse[3][3] = 1;
    return inverse;
}

}  // namespace irt
