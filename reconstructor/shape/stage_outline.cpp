// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/shape/stage_outline.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "reconstructor/shape/sheet_light.h"

namespace sheen {
namespace {

constexpr std::size_t kFewestTags = 3;
constexpr float kPure = 0.02f;  // share of ink up to which a pixel is paper
// Light on paper, of what the tags show.
constexpr float kDarkest = 0.15f, kBrightest = 1.25f;
constexpr float kNoise = 0.012f;
constexpr float kGlow = 0.15f;    // a channel from their mean, relative: also where it is lit by what stands beside it
constexpr float kChroma = 0.06f;  // likewise, to be taken for paper where there is none, ...
constexpr float kBright = 0.4f;   // ... and at least so bright
constexpr float kStep = 0.05f;    // of its logarithm, from a pixel to the next: more is an edge
constexpr float kExpected = 0.07f;  // likewise, from the mean of what is round it
constexpr int kSquare_px = 16;      // of which the mean is taken
// Ink, as a share between paper and ink.
constexpr float kTolerance = 0.15f;
constexpr float kGrey = 0.12f;   // between the channels
constexpr float kDark = 0.75f;   // looks like ink
constexpr float kHidden = 0.9f;  // must be ink
// What is round a pixel of a tag, in pixels to each side.
constexpr int kRound = 2, kRounds = 2;
constexpr double kAlone = 0.4;            // where more of it is not like the sheet, the pixel is not either
constexpr int kPattern = 4, kOfEach = 8;  // so many of ink and of paper tell a pattern
// Pixels of a piece.
constexpr std::size_t kHangsTogether = 12, kEnclosed = 30;
constexpr double kInDoubt = 0.5;  // of the sheet's pixels: with more a view says nothing

constexpr float kNot = std::numeric_limits<float>::quiet_NaN();

/// How each pixel looks beside what the sheet must look like there.
struct Looks {
  ImageU8 like;  ///< 1: as the sheet in some light; 2: as the sheet in the light that the tags show
  ImageU8 dark;  ///< 1: as ink, whatever must be there
  ImageF light;  ///< RGB, logarithm: on what must be paper, of what the tags show; NaN elsewhere
  std::size_t before_ink = 0, white = 0;  ///< see `SheetSeen`
};

/// Paper in a shadow, or with a glow of what stands beside it.
bool is_lit_paper(const Eigen::Array3f& of_paper, float glow) {
  const float light = of_paper.mean();
  const float off = (of_paper / light - 1).abs().maxCoeff();
  return light > kDarkest && light < kBrightest && off < glow + kNoise / light;
}

Looks looks_of(const SheetPrediction& predicted, const SheetLight& light, const ImageF& colour) {
  Looks looks{.like = ImageU8(colour.width(), colour.height(), 1),
              .dark = ImageU8(colour.width(), colour.height(), 1),
              .light = ImageF(colour.width(), colour.height(), 3, kNot)};
  for (std::size_t p = 0; p < predicted.tag.size(); ++p) {
    const float least = predicted.least_ink.data()[p], most = predicted.most_ink.data()[p];
    const Eigen::Array3f rgb = Eigen::Map<const Eigen::Array3f>(colour.data() + 3 * p);
    if (std::isnan(least) || !rgb.allFinite()) continue;
    const Eigen::Array3f of_paper = rgb / light.paper_at(predicted.point[p]);
    const Eigen::Array3f ink = (1 - of_paper) / (1 - light.ink);  // share, as each channel has it
    looks.dark.data()[p] = ink.minCoeff() > kDark ? 1 : 0;
    const bool tag_seen = predicted.tag[p] >= 0 && light.seen[predicted.tag[p]];
    if (most <= kPure) {
      if (!is_lit_paper(of_paper, kGlow)) continue;
      Eigen::Map<Eigen::Array3f>(looks.light.data() + 3 * p) = of_paper.log();
      looks.like.data()[p] = tag_seen && (of_paper - 1).abs().maxCoeff() < kTolerance ? 2 : 1;
    } else {
      const bool grey = ink.maxCoeff() - ink.minCoeff() < kGrey;
      if (grey && ink.minCoeff() > least - kTolerance && ink.maxCoeff() < most + kTolerance) {
        looks.like.data()[p] = tag_seen ? 2 : 1;
      } else if (predicted.ink.data()[p] > kHidden) {
        ++looks.before_ink;
        looks.white += of_paper.mean() > kBright && is_lit_paper(of_paper, kChroma) ? 1 : 0;
      }
    }
  }
  return looks;
}

/// The pixels round one.
struct Round {
  int all = 0, unlike = 0, ink = 0, paper = 0;
  Round(const SheetPrediction& predicted, const ImageU8& like, int x, int y, int reach) {
    for (int py = std::max(0, y - reach); py <= std::min(like.height() - 1, y + reach); ++py)
      for (int px = std::max(0, x - reach); px <= std::min(like.width() - 1, x + reach); ++px) {
        if (std::isnan(predicted.least_ink.at(px, py))) continue;
        ++all;
        unlike += like.at(px, py) == 0 ? 1 : 0;
        ink += predicted.ink.at(px, py) > 0.8f ? 1 : 0;
        paper += predicted.ink.at(px, py) < 0.2f ? 1 : 0;
      }
  }
};

/// The edges of the tags look like nearly anything grey: they are the sheet only where what is round them is. And where
/// ink and paper are all as they must be that is the sheet, though the whole tag is not seen.
void judge_tags_by_what_is_round(const SheetPrediction& predicted, ImageU8& like) {
  for (int round = 0; round < kRounds; ++round) {
    const ImageU8 before = like;
    for (int y = 0; y < like.height(); ++y)
      for (int x = 0; x < like.width(); ++x)
        if (before.at(x, y) != 0 && predicted.most_ink.at(x, y) > kPure) {
          const Round all(predicted, before, x, y, kRound);
          if (all.unlike > kAlone * all.all) like.at(x, y) = 0;
        }
  }
  const ImageU8 before = like;
  for (int y = 0; y < like.height(); ++y)
    for (int x = 0; x < like.width(); ++x)
      if (before.at(x, y) == 1 && predicted.most_ink.at(x, y) > kPure) {
        const Round all(predicted, before, x, y, kPattern);
        if (all.unlike == 0 && std::min(all.ink, all.paper) >= kOfEach) like.at(x, y) = 2;
      }
}

/// Calls `visit(x, y)` for the four neighbours in the image.
template <typename Visit>
void for_neighbours(const ImageU8& image, int x, int y, const Visit& visit) {
  if (x > 0) visit(x - 1, y);
  if (y > 0) visit(x, y - 1);
  if (x + 1 < image.width()) visit(x + 1, y);
  if (y + 1 < image.height()) visit(x, y + 1);
}

/// Calls `take(piece)` with the pixels of each piece of what is not 0.
template <typename Take>
void for_pieces(const ImageU8& image, const Take& take) {
  ImageU8 left = image;
  std::vector<std::pair<int, int>> piece;
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x) {
      piece.clear();
      const auto add = [&](int nx, int ny) {
        if (left.at(nx, ny) == 0) return;
        left.at(nx, ny) = 0;
        piece.emplace_back(nx, ny);
      };
      add(x, y);
      for (std::size_t i = 0; i < piece.size(); ++i) {
        const auto [px, py] = piece[i];
        for_neighbours(image, px, py, add);
      }
      if (!piece.empty()) take(piece);
    }
}

/// What looks like ink and hangs together is ink as a whole, or not at all: a black object covers black cells, too.
void doubt_dark_objects(Looks& looks) {
  for_pieces(looks.dark, [&](const std::vector<std::pair<int, int>>& piece) {
    const auto unlike = std::count_if(piece.begin(), piece.end(),
                                      [&](const auto& at) { return looks.like.at(at.first, at.second) == 0; });
    if (static_cast<std::size_t>(unlike) < kHangsTogether) return;
    for (const auto& [x, y] : piece) looks.like.at(x, y) = 0;
  });
}

constexpr auto kBackground = static_cast<std::uint8_t>(Outline::kBackground),
               kUnknown = static_cast<std::uint8_t>(Outline::kUnknown),
               kObject = static_cast<std::uint8_t>(Outline::kObject);

/// The light without the noise of single pixels: its mean over the neighbours that have one.
ImageF smoothed(const ImageF& light) {
  ImageF smooth(light.width(), light.height(), 3, kNot);
  for (int y = 1; y + 1 < light.height(); ++y)
    for (int x = 1; x + 1 < light.width(); ++x) {
      if (std::isnan(light.at(x, y))) continue;
      Eigen::Array3f sum = Eigen::Array3f::Zero();
      float count = 0;
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
          const Eigen::Map<const Eigen::Array3f> beside(light.pixel(x + dx, y + dy));
          if (std::isnan(beside[0])) continue;
          sum += beside;
          count += 1;
        }
      Eigen::Map<Eigen::Array3f>(smooth.pixel(x, y)) = sum / count;
    }
  return smooth;
}

std::vector<std::pair<int, int>> all_of(const ImageU8& image, std::uint8_t value) {
  std::vector<std::pair<int, int>> all;
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x)
      if (image.at(x, y) == value) all.emplace_back(x, y);
  return all;
}

/// Over all that looks like the sheet, as long as the light on it changes slowly.
void spread_background(const ImageU8& like, const ImageF& light, std::vector<std::pair<int, int>> from,
                       ImageU8& outline) {
  for (const auto& [x, y] : from) outline.at(x, y) = kBackground;
  while (!from.empty()) {
    const auto [x, y] = from.back();
    from.pop_back();
    const Eigen::Map<const Eigen::Array3f> here(light.pixel(x, y));
    for_neighbours(outline, x, y, [&](int nx, int ny) {
      if (like.at(nx, ny) == 0 || outline.at(nx, ny) != kUnknown) return;
      const Eigen::Map<const Eigen::Array3f> there(light.pixel(nx, ny));
      if ((there - here).abs().maxCoeff() > kStep) return;  // never so beside a tag, where there is no light
      outline.at(nx, ny) = kBackground;
      from.emplace_back(nx, ny);
    });
  }
}

/// The light that the background near it lets expect on a pixel that it could not spread to: squares of the image,
/// those without background filled from their neighbours.
class ExpectedLight {
 public:
  ExpectedLight(const ImageF& light, const ImageU8& outline)
      : columns_(outline.width() / kSquare_px + 1),
        squares_(std::size_t(columns_) * (outline.height() / kSquare_px + 1), Eigen::Array4f::Zero()) {
    for (int y = 0; y < outline.height(); ++y)
      for (int x = 0; x < outline.width(); ++x) {
        if (outline.at(x, y) != kBackground || std::isnan(light.at(x, y))) continue;
        Eigen::Array4f& square = squares_[number(x, y)];
        square.head<3>() += Eigen::Map<const Eigen::Array3f>(light.pixel(x, y));
        square[3] += 1;
      }
  }
  /// NaN where there is no background within a few squares.
  Eigen::Array3f at(int x, int y) const {
    Eigen::Array4f sum = Eigen::Array4f::Zero();
    const int column = x / kSquare_px, row = y / kSquare_px;
    const int rows = static_cast<int>(squares_.size()) / columns_;
    for (int reach = 1; reach <= 3 && sum[3] == 0; ++reach)
      for (int r = std::max(0, row - reach); r <= std::min(rows - 1, row + reach); ++r)
        for (int c = std::max(0, column - reach); c <= std::min(columns_ - 1, column + reach); ++c)
          sum += squares_[std::size_t(r) * columns_ + c];
    return sum.head<3>() / sum[3];
  }

 private:
  std::size_t number(int x, int y) const { return std::size_t(y / kSquare_px) * columns_ + x / kSquare_px; }
  int columns_;
  std::vector<Eigen::Array4f> squares_;  ///< sums of light, and of how many
};

/// Paper that the object encloses in the image, as within a handle: it has the light that is to be expected there.
std::vector<std::pair<int, int>> enclosed_paper(const ImageF& light, const ImageU8& outline) {
  const ExpectedLight expected(light, outline);
  ImageU8 fits(outline.width(), outline.height(), 1);
  for (int y = 0; y < outline.height(); ++y)
    for (int x = 0; x < outline.width(); ++x) {
      if (outline.at(x, y) != kUnknown || std::isnan(light.at(x, y))) continue;
      const Eigen::Map<const Eigen::Array3f> here(light.pixel(x, y));
      fits.at(x, y) = (here - expected.at(x, y)).abs().maxCoeff() < kExpected ? 1 : 0;
    }
  std::vector<std::pair<int, int>> enclosed;
  for_pieces(fits, [&](const std::vector<std::pair<int, int>>& piece) {
    if (piece.size() >= kEnclosed) enclosed.insert(enclosed.end(), piece.begin(), piece.end());
  });
  return enclosed;
}

/// What is not like the sheet and hangs together.
void mark_object(const SheetPrediction& predicted, const ImageU8& like, ImageU8& outline) {
  ImageU8 unlike(outline.width(), outline.height(), 1);
  for (std::size_t p = 0; p < unlike.size(); ++p)
    unlike.data()[p] = like.data()[p] == 0 && !std::isnan(predicted.least_ink.data()[p]) ? 1 : 0;
  for_pieces(unlike, [&](const std::vector<std::pair<int, int>>& piece) {
    if (piece.size() < kHangsTogether) return;
    for (const auto& [x, y] : piece) outline.at(x, y) = kObject;
  });
}

/// Where a whole view of the image, coarser, has nothing but background round a pixel.
std::vector<std::pair<int, int>> surely_background(const SheetSeen& whole, const Camera& part, const ImageU8& like) {
  std::vector<std::pair<int, int>> sure;
  const Camera& w = whole.camera;
  for (int y = 0; y < like.height(); ++y)
    for (int x = 0; x < like.width(); ++x) {
      const auto u = static_cast<int>(std::lround((x - part.cx) / part.fx * w.fx + w.cx));
      const auto v = static_cast<int>(std::lround((y - part.cy) / part.fy * w.fy + w.cy));
      if (like.at(x, y) == 0 || u < 1 || v < 1 || u + 1 >= w.width || v + 1 >= w.height) continue;
      bool background = true;
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) background = background && whole.outline.at(u + dx, v + dy) == kBackground;
      if (background) sure.emplace_back(x, y);
    }
  return sure;
}

bool mostly_known(const SheetPrediction& predicted, const ImageU8& outline) {
  double on_sheet = 0, in_doubt = 0;
  for (std::size_t p = 0; p < outline.size(); ++p) {
    if (std::isnan(predicted.least_ink.data()[p])) continue;
    on_sheet += 1;
    in_doubt += outline.data()[p] == kUnknown ? 1 : 0;
  }
  return in_doubt < kInDoubt * on_sheet;
}

/// `whole`: where there is one.
void mark(const SheetPrediction& predicted, Looks looks, const SheetSeen* whole, ShapeView& view) {
  doubt_dark_objects(looks);
  judge_tags_by_what_is_round(predicted, looks.like);
  ImageU8 outline(looks.like.width(), looks.like.height(), 1, kUnknown);
  const ImageF light = smoothed(looks.light);
  spread_background(looks.like, light, all_of(looks.like, 2), outline);
  if (whole) spread_background(looks.like, light, surely_background(*whole, view.camera.camera, looks.like), outline);
  spread_background(looks.like, light, enclosed_paper(light, outline), outline);
  mark_object(predicted, looks.like, outline);
  view.before_sheet = mostly_known(predicted, outline);
  if (view.before_sheet) view.outline = std::move(outline);
}

}  // namespace

SheetSeen mark_sheet(const StagePicture& sheet, const ImageF& colour, ShapeView& view) {
  const SheetPrediction predicted = predict(sheet, view.camera);
  SheetSeen seen{.light = fit_light(sheet, predicted, colour), .camera = view.camera.camera, .outline = {}};
  if (seen.light.tags.size() < kFewestTags) return seen;
  const Looks looks = looks_of(predicted, seen.light, colour);
  seen.before_ink = looks.before_ink;
  seen.white = looks.white;
  mark(predicted, looks, nullptr, view);
  seen.outline = view.outline;
  return seen;
}

void mark_sheet(const StagePicture& sheet, const ImageF& colour, const SheetSeen& whole, ShapeView& part) {
  if (whole.outline.empty()) return;
  const SheetPrediction predicted = predict(sheet, part.camera);
  mark(predicted, looks_of(predicted, whole.light, colour), &whole, part);
}

}  // namespace sheen
