// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "reconstructor/lumigraph_file/intrinsic_view.h"
#include "reconstructor/models/intrinsic_lumigraph/captured_view.h"

namespace sheen {

/// Light where no lamp's arrives, in units of the lamps' (`LightSet::incidence`): the median over pixels that some
/// images show lit and some in shadow. Needs normals. 0 where nothing says it.
double ambient_light(const CapturedView& view, const LightSet& lights);

/// The same without normals: the median of I / R over all shadows, in units of what R leaves to the light.
double ambient_light(const CapturedView& view, const ImageF& reflectance);

/// Reflectance of a view whose geometry is known (001 eq. 5 to 7, log domain): the median over the lights that arrive
/// of log I - log L, where L follows from normals and visibility. Pixels that no light reaches are judged by ambient
/// light. RGB.
ImageF known_reflectance(const CapturedView& view, const LightSet& lights, double ambient);

/// All of a view's terms but the reflectance, which is given. Ambient light and b are found by
/// least squares over all images, held near `ambient` and the normal where these say too little.
IntrinsicView decompose(const CapturedView& view, const LightSet& lights, const ImageF& reflectance, double ambient);

}  // namespace sheen
