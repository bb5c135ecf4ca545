// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/commands/film.h"

#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/base/progress.h"
#include "common/base/stop_signal.h"
#include "common/image/color.h"
#include "reconstructor/exchange/video_file.h"

namespace sheen {
namespace {

std::array<std::uint8_t, 3> colour_of(const std::string& word) {
  const bool is_colour =
      word.size() == 7 && word[0] == '#' && word.find_first_not_of("0123456789abcdefABCDEF", 1) == std::string::npos;
  if (!is_colour) throw ConfigError("--background: must be a colour such as #ffffff, not " + word);
  const unsigned long rgb = std::stoul(word.substr(1), nullptr, 16);
  return {static_cast<std::uint8_t>(rgb >> 16), static_cast<std::uint8_t>(rgb >> 8 & 0xff),
          static_cast<std::uint8_t>(rgb & 0xff)};
}

std::uint8_t mixed(std::uint8_t front, std::uint8_t behind, std::uint8_t alpha) {
  if (alpha == 255) return front;
  const float part = static_cast<float>(alpha) / 255;
  const float light =
      part * srgb_decode(static_cast<float>(front) / 255) + (1 - part) * srgb_decode(static_cast<float>(behind) / 255);
  std::uint8_t code = 0;
  to_srgb8({&light, 1}, &code);
  return code;
}

}  // namespace

void FilmRequest::add_to(Command& command) {
  command.option("--fps", frames_per_s, "pictures a second of a video").show_default().check(whole_number_in(1, 240));
  command.option("--background", background, "colour behind the object in a video").show_default();
}

bool is_film(const std::filesystem::path& out) {
  return video_kind(out).has_value();
}

ImageU8 over_background(const ImageU8& picture, const std::string& background) {
  const std::array<std::uint8_t, 3> colour = colour_of(background);
  if (picture.channels() != 4) return picture;
  ImageU8 out(picture.width(), picture.height(), 3);
  for (int y = 0; y < out.height(); ++y)
    for (int x = 0; x < out.width(); ++x)
      for (int c = 0; c < 3; ++c)
        out.at(x, y, c) = mixed(picture.at(x, y, c), colour[static_cast<std::size_t>(c)], picture.at(x, y, 3));
  return out;
}

nlohmann::json write_film(const std::filesystem::path& out, const FilmRequest& request, std::size_t count,
                          const std::function<ImageU8(std::size_t)>& picture) {
  check_writable(out);
  colour_of(request.background);
  install_stop_signals();
  ImageSize size;
  write_file(out, [&](const std::filesystem::path& unfinished) {
    std::optional<VideoFile> video;
    Progress progress("rendering", count);
    for (std::size_t i = 0; i < count; ++i) {
      if (stop_requested()) throw Error("stopped after " + std::to_string(i) + " pictures; no video was written");
      const ImageU8 frame = over_background(picture(i), request.background);
      if (i == 0) {
        size = {frame.width(), frame.height()};
        if (size.width % 2 != 0 || size.height % 2 != 0)
          throw ConfigError(out.string() + ": the sides of a video are even, and these pictures are " +
                            std::to_string(size.width) + " x " + std::to_string(size.height) + "; see --size");
        video.emplace(unfinished, *video_kind(out), size, request.frames_per_s);
      }
      video->add(frame);
      progress.update(i + 1);
    }
    video->finish();
  });
  std::printf("%s written: %zu pictures of %d x %d, %d a second\n", out.c_str(), count, size.width, size.height,
              request.frames_per_s);
  return {{"path", out.string()},
          {"frames", count},
          {"frames_per_s", request.frames_per_s},
          {"width", size.width},
          {"height", size.height}};
}

}  // namespace sheen
