// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "reconstructor/shape/surface_sight.h"
#include "reconstructor/shape/view_agreement.h"

namespace sheen {

struct ShapeImages;
struct ObjectPlace;

/// What was measured of one image while a shape was found.
struct ShapeViewMeasures {
  std::string name;               ///< of the image, for people
  bool outlined = false;          ///< it has an outline
  std::optional<double> overlap;  ///< of its outline with the found shape, intersection over union; empty without one,
                                  ///< and of one that a stage's sheet showed, which is rough
  double thin_missing = 0;        ///< of the object's pixels: in thin parts that the shape has not
  std::optional<double> alike;    ///< of places that others found and it should show: it shows the same there
  bool cut = false;               ///< its outline runs along the rim of the image
};

/// What was measured while a shape was found.
struct ShapeMeasures {
  std::vector<ShapeViewMeasures> views;  ///< in the order of the images
  std::optional<Split> moved;            ///< the images before and after agree among themselves, not with each other
  std::optional<double> off_px;          ///< by which images show places aside of where the poses have them: median
  double angle_between = 0;              ///< of a view and the third nearest to it: median, rad
  SurfaceSight sight;
  std::string beside;    ///< the image that is nearest to looking at what fewer than three look at
  double at_border = 0;  ///< of the shape's area: lies where the space that was looked in ends
  double cell_px = 0;    ///< of the lattice that the shape was put together in, pixels of an image
};

/// `views`: of the images that are used, in their order; their outlines are looked at, no longer their grey. `pairs`:
/// of these. `cell`: of the lattice, metres.
ShapeMeasures measure_shape(const ShapeImages& images, const ObjectPlace& place, std::span<const ShapeView> views,
                            std::span<const PairAgreement> pairs, const Mesh& mesh, double cell);

}  // namespace sheen
