// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/capture/capture.h"
#include "common/datasets/image_account.h"

namespace sheen {

/// One posed image of a dataset, not yet read.
struct DatasetView {
  std::string name;  ///< `file_path` as the dataset writes it, with slashes
  std::filesystem::path image_path;
  std::optional<std::filesystem::path> mask_path;
  Camera camera;
  Rigid3 camera_from_object;
  LightState light;  ///< what the frame's light keys say; fixed without them
  Purpose purpose = Purpose::kUnspecified;
  std::optional<double> exposure_s;  ///< from EXIF or the file, when it is there
  double gain_db = 0;                ///< likewise: 20 log10(ISO / 100 / f-number^2), what a grey level is multiplied by
  bool exposure_locked = false;      ///< all images that say so have one exposure
  int exif_orientation = 1;          ///< 1..8; the pixels are taken as they are stored, whatever it says
  ImageSize image_size{}, mask_size{};  ///< of the files; 0 x 0 where there is none, or it was not looked at
};

/// Posed image set: a folder with `transforms.json` (nerfstudio / instant-ngp keys, OpenGL axes), with
/// `transforms_train.json` and `transforms_test.json`, or with a COLMAP model. Views stand in the order of the file.
struct Dataset {
  std::filesystem::path root;
  std::vector<DatasetView> views;
  /// Of the description and the bytes of every image and mask: names the source session, so that a repeated run is
  /// recognised and a changed image is not taken for known.
  std::string hash;
  ImageAccount account;
  /// What a person should know about how it was read or what is doubtful, a sentence a line; empty: nothing.
  std::string warning;
};

/// Every image and mask is decoded once: what is missing or damaged is left out and stands in the account. Names are
/// found as `FileFinder` does. The path of the `transforms.json` itself will do as well.
///
/// Without `transforms.json` the views of `transforms_train.json` are for training, those of `transforms_test.json`
/// (without it: `transforms_val.json`) are held out. Of COLMAP models (binary or text, in the folder, its `sparse` and
/// the folders in it) the one with most images is read; images lie in `images`, else in the folder; masks, if any, in
/// `masks` (`find_colmap_mask`).
///
/// Throws FileError naming file, frame and field, also where fewer than half of the images are left.
Dataset load_dataset(const std::filesystem::path& folder);

/// Whether a folder says where its images were taken from, so that `load_dataset` has something to read.
bool holds_poses(const std::filesystem::path& folder);

/// Throws FileError that names the first image or mask whose size is not its camera's, with both sizes.
void check_sizes(const Dataset& dataset);

/// Cameras and names of a `transforms.json` whose images need not exist, to render from, or of nerfstudio's
/// `camera_path.json`; names in lists that no frame has (a few frames of a data set) are passed over. Throws FileError,
/// also where `w` and `h` are missing.
std::vector<DatasetView> load_cameras(const std::filesystem::path& transforms_json);

/// Reads a view's image (JPEG, PNG, WebP: 8-bit sRGB; EXR: linear float) and mask: its file, else the alpha of the
/// image. `sequence` counts from 1. An image whose size differs from its camera's is an error that names both.
Capture read_capture(const Dataset& dataset, std::size_t view);

/// Text of a `transforms.json` for these views (OpenGL axes, principal point shifted by 0.5), masks of the views
/// that have one, train / val / test lists where any view is held out, the first alone where all are for training.
/// `file`: what it is to be written as. `points`: a PLY file that trainers begin with, as seen from there; empty: none.
/// Throws FileError.
std::string transforms_text(const std::filesystem::path& file, const std::vector<DatasetView>& views,
                            const std::string& points = {});
void write_transforms(const std::filesystem::path& file, const std::vector<DatasetView>& views,
                      const std::string& points = {});

}  // namespace sheen
