// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <vector>

#include "common/camera/camera.h"
#include "common/geometry/mesh.h"
#include "common/image/image.h"

// Pages in a real browser: what they show from an eye, and how far that is off.
namespace sheen {

inline constexpr int kPageWidth = 480, kPageHeight = 360;

struct Eye {
  Eigen::Vector3d place, target, up;
};
/// On all sides of the object, near and far, the camera upright in the object's frame.
std::vector<Eye> eyes_round(const BoundingSphere& object, int count);
/// That of the page's picture.
Camera page_camera();

/// What a page showed.
struct Shown {
  std::vector<ImageU8> pictures;  ///< RGBA
  nlohmann::json figures;
};
/// How the page is shown.
struct Showing {
  bool lose = false;  ///< twice from each eye, the second time when the page has lost its graphics and got them back
  int port = 0;       ///< of a monitor that has the page; 0: it is in the folder
  /// Called after so many pictures. Whether it changed the page's model: then the page is asked again from there.
  std::function<bool(std::size_t)> change;
};
/// The page of a folder, from these eyes.
Shown shown_in_browser(const std::filesystem::path& folder, const std::vector<Eye>& eyes, const Showing& how = {});
/// In lights from these directions.
Shown lit_in_browser(const std::filesystem::path& folder, const std::vector<Eigen::Vector3d>& lights);

/// How far a picture is off, where no outline of the surface runs near.
struct Difference {
  double mean = 0;
  std::size_t values = 0, off = 0;  ///< by more than 2 of 255
  std::size_t missing = 0;          ///< pixels of one that the other has not
};
Difference difference(const ImageU8& shown, const ImageU8& truth, const ImageU8& outline);

}  // namespace sheen
