// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/camera/posed_camera.h"
#include "common/capture/capture.h"
#include "common/datasets/image_account.h"

namespace sheen {

/// An image of a list of lights, and the light that it was taken in.
struct LitView {
  std::string name;  ///< as the list has it
  LightState light;
};

/// A list of lights as RTI tools write it (.lp): the number of images, then for each a line `name x y z`, the
/// name with or without quotes. The first line may say what x y z are: "49 directions" towards far lights (of any
/// length), or "49 positions" of near ones. Else they are directions where all are unit vectors to 2 %, and positions
/// where hardly any is. Axes: x right, y up in the picture, z towards the camera. Throws FileError naming file and
/// line.
std::vector<LitView> parse_light_list(const std::string& file, std::string_view text);
/// Such a list, exact; its lights are of one kind, directional or point. Says what they are only where their lengths
/// would be misread, so that other tools read it, too.
std::string light_list_text(std::span<const LitView> views);
/// What the lights of such a text, parsed before, are taken for where its first line does not say; empty: it says.
std::string assumption_about(const std::string& file, std::string_view text, std::span<const LitView> views);

inline constexpr std::size_t kMostListBytes = std::size_t{1} << 22;
/// Lights alone, to be rendered: the images need not be there.
std::vector<LitView> load_lights(const std::filesystem::path& list);

/// Images of one camera that stands still, each in its light.
struct LightList {
  std::vector<LitView> views;
  std::vector<std::filesystem::path> images;  ///< per view
  PosedCamera camera;
  std::string hash;  ///< of the list and the bytes of every image
  ImageAccount account;
  std::string doubt;  ///< what its lights are taken for where it does not say, a sentence; empty: it says
};

/// Images are looked for beside the list, by their name and by its last part (tools write the paths of their own
/// machine), as `FileFinder` does. Those that are missing or damaged are left out. Their camera is not known: it is
/// taken to look along -z from one metre, its picture's longer side one metre long round the object's origin. Throws
/// FileError, also where images differ in size or fewer than half are left.
LightList load_light_list(const std::filesystem::path& list);
/// Reads an image (as `read_capture` of a dataset). Its mask is set everywhere: all of the picture counts.
Capture read_capture(const LightList& list, std::size_t view);

}  // namespace sheen
