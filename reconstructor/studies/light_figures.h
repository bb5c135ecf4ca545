// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "reconstructor/studies/figure.h"

namespace sheen {

// The experiments of the reflected irradiance field (002), with a lamp that moves on a plane over the simulated object,
// in direct light with exact shadows. Errors are those of bilinear interpolation of exposure, in grey levels of which
// the brightest surface has 255. "Lit" are pixels that the lamp reaches from all places that count.

struct LightFigureOptions {
  int width = 200, height = 150;  ///< pixels
  int lamps = 12;                 ///< places of the lamp, where interpolation has truth
};

/// Figure 3: exposure against the lamp's place of two pixels, and how far apart each could do with samples.
Figure figure_exposure_curves(const LightFigureOptions& options);

/// Figure 5: a glossy surface from samples at 0.91, 2, 4 and 8 times the planned spacing.
Figure figure_undersampling(const LightFigureOptions& options);

/// Figure 7: the same of two brushed metals (Lafortune lobes that see one direction of the surface only).
Figure figure_brushed_metals(const LightFigureOptions& options);

}  // namespace sheen
