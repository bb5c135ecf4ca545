// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "reconstructor/shape/shape_view.h"
#include "reconstructor/shape/sheet_light.h"
#include "reconstructor/shape/stage_picture.h"

namespace sheen {

/// What a view shows of a stage's sheet.
struct SheetSeen {
  SheetLight light;
  Camera camera;
  ImageU8 outline;             ///< as the view has it; empty where it says nothing
  std::size_t before_ink = 0;  ///< pixels of what hides ink, ...
  std::size_t white = 0;       ///< ... and of these, as bright and of the same colour as the paper
};

/// Marks the outline in a view without a mask from the known picture of the sheet that the object stands on.
/// Background: the sheet, seen as it must look there, its light fitted at the tags of this very view; a shadow or a
/// slow change of light is no difference, an edge in the light ends what is known. Object: what hides the sheet, and
/// hangs together. Unknown: what is off the sheet or in doubt. `colour`: the view's linear RGB, NaN where it has none.
/// The outline stays empty where the view does not show the tags where they must be, or most of its sheet is in
/// doubt.
SheetSeen mark_sheet(const StagePicture& sheet, const ImageF& colour, ShapeView& view);

/// The same in a part of an image, finer, of which `whole` was seen: the part need not have tags.
void mark_sheet(const StagePicture& sheet, const ImageF& colour, const SheetSeen& whole, ShapeView& part);

}  // namespace sheen
