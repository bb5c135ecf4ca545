// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common/image/image.h"

namespace sheen {

/// Sheen's own single-stroke font: printable ASCII, fixed width, drawn at any size.
struct GlyphAtlas {
  static constexpr int kFirst = 32, kLast = 126, kColumns = 16;

  ImageU8 coverage;    ///< 1 channel; glyph g stands in cell ((g - kFirst) % kColumns, (g - kFirst) / kColumns)
  int cell_width = 0;  ///< pixels: also the advance
  int cell_height = 0;
};

/// Draws all glyphs with antialiased strokes. `unit` is a sixth of a capital's height, in pixels, 1.5 or more.
GlyphAtlas draw_glyphs(float unit);

}  // namespace sheen
