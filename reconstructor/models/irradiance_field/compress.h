// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "reconstructor/models/irradiance_field/irradiance_field_snapshot.h"

namespace sheen {

/// The finest step that files in so many bytes have, in grey levels: what it rounds away is less than 8-bit pictures
/// do.
inline constexpr double kFinestStep = 1;
/// The step of a field that is not to be small: as good as exact.
inline constexpr float kExactStep = 0.25f;

/// `ModelSnapshot::compression` of an irradiance field: the step is searched that takes the bytes or loses what may be
/// lost. Bytes are left over only at `kFinestStep`.
std::unique_ptr<Compression> compress_field(const IrradianceFieldSnapshot& exact, CompressionTarget target);

}  // namespace sheen
