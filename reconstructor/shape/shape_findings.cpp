// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/shape/shape_findings.h"

#include <algorithm>
#include <functional>

#include "common/base/angle.h"
#include "common/base/format.h"
#include "common/base/order_statistics.h"

namespace sheen {
namespace {

constexpr double kOff_px = 0.6;         // median of the pairs of views
constexpr double kMuchOff_px = 1.5;     // what is further off is not found at all, so it cannot be told how far
constexpr double kStrange = 0.3;        // of what others show alike: below, an image shows something else
constexpr double kMisfit = 0.1;         // of overlap, below that of the usual outline
constexpr double kUsualOverlap = 0.85;  // below, outlines do not fit each other at all
constexpr double kFewOutlines = 0.5;    // of the images
constexpr double kAtBorder = 0.01, kSmooth = 0.1, kUnderneath = 0.03, kAside = 0.05;  // of the area
constexpr double kFarApart = 35 * kDegree;
constexpr double kThin = 0.002, kImagesWithThin = 0.2;
constexpr double kImagesCut = 0.1;

std::string percent(double share) {
  return format("%.0f %%", 100 * share);
}

/// "a.jpg, b.jpg, c.jpg and 4 more"
std::string list(const std::vector<std::string>& names) {
  constexpr std::size_t kNamed = 3;
  std::string text;
  for (std::size_t i = 0; i < std::min(kNamed, names.size()); ++i) text += (i > 0 ? ", " : "") + names[i];
  return names.size() > kNamed ? text + format(" and %zu more", names.size() - kNamed) : text;
}

std::vector<std::string> names_where(const ShapeMeasures& measures,
                                     const std::function<bool(const ShapeViewMeasures&)>& holds) {
  std::vector<std::string> names;
  for (const ShapeViewMeasures& view : measures.views)
    if (holds(view)) names.push_back(view.name);
  return names;
}

/// Median of what is known of the views; empty where it is known of none.
std::optional<double> usual(const ShapeMeasures& measures, std::optional<double> ShapeViewMeasures::*value) {
  std::vector<double> known;
  for (const ShapeViewMeasures& view : measures.views)
    if (view.*value) known.push_back(*(view.*value));
  return known.empty() ? std::nullopt : std::optional(median(known));
}

ShapeFinding moved(const ShapeMeasures& measures) {
  const std::string& last = measures.views[measures.moved->after].name;
  return {"moved",
          "the object moved on the stage, or the stage did, after " + last +
              ": the images up to it agree with each other, and so do those after it, but not the two with each "
              "other; use those before or those after it alone",
          {last}};
}

ShapeFinding poses(double off_px) {
  const std::string off =
      off_px < kMuchOff_px ? format("by %.1f pixels", off_px) : format("by %.1f pixels or more", kMuchOff_px);
  return {"poses",
          "the poses are off " + off +
              ": so far aside images show what others have found; `refine --poses` corrects those of a data set, a new "
              "calibration of the camera those of a session"};
}

ShapeFinding strange(std::vector<std::string> names) {
  return {"images",
          list(names) +
              ": the others' surface is not to be seen there; the pose is wrong, or something stood before the "
              "object: leave these images out",
          names};
}

ShapeFinding misfits(std::vector<std::string> names) {
  return {"outlines",
          list(names) +
              ": the outline of the object does not fit the outlines of the other images, its surface does; "
              "correct these masks, or leave them out",
          names};
}

ShapeFinding outlines_apart(double overlap) {
  return {"outlines", "the outlines of most images do not fit each other (they overlap with the shape by " +
                          percent(overlap) + "): check the masks, and the poses"};
}

ShapeFinding background(std::size_t without, std::size_t all) {
  return {"background", format("in %zu of %zu images object and background cannot be told apart, so what stands round "
                               "the object becomes part "
                               "of the shape: give masks, or take the images before a plain dark or bright background",
                               without, all)};
}

ShapeFinding cut_off(double share) {
  return {.kind = "cut off",
          .sentence =
              "the object reaches beyond the space that was looked in, and is cut off there (" + percent(share) +
              " of its surface): it must lie between the stage's tags, and within the picture in more of the images",
          .passes_with_more_images = true};  // the space is where enough images look
}

ShapeFinding cut_by_frames(std::vector<std::string> names, std::size_t all) {
  return {"cut off",
          format("the object reaches out of the picture in %zu of %zu images (", names.size(), all) + list(names) +
              "): step back so that all of it is in each",
          names};
}

ShapeFinding directions(const ShapeMeasures& measures, bool one_sided) {
  std::string text = "the images are from too few directions: ";
  if (one_sided)
    text += percent(measures.sight.aside) +
            " of the surface is looked at by fewer than three of them, most of it beside " + "what " + measures.beside +
            " shows";
  else
    text += format("neighbouring ones are %.0f degrees apart", measures.angle_between / kDegree);
  return {.kind = "directions",
          .sentence = text + "; take more in steps of 10 to 15 degrees",
          .passes_with_more_images = true};
}

ShapeFinding smooth(double share) {
  return {.kind = "smooth",
          .sentence = percent(share) +
                      " of the surface is looked at from several sides, and yet no two images agree where it is: it "
                      "is without texture, like a mirror, or transparent; an even coat of powder or spots of "
                      "washable paint help, and outlines (masks, a plain background) bound it",
          .passes_with_more_images = true};
}

ShapeFinding thin(double cell_px) {
  return {.kind = "thin",
          .sentence = format(
              "parts of the object that are only some pixels wide are missing: what is thinner than about %.0f pixels "
              "is lost; go nearer, or take images of more pixels",
              2 * cell_px),
          .passes_with_more_images = true};
}

ShapeFinding underside(double share) {
  return {.kind = "underside",
          .sentence =
              "no image shows the underside (" + percent(share) +
              " of the surface), which is closed by a guess; where it matters, stand the object on something thin, or "
              "lay it on its side and take all images anew",
          .passes_with_more_images = true};
}

}  // namespace

std::vector<ShapeFinding> findings_of(const ShapeMeasures& measures) {
  std::vector<ShapeFinding> found;
  const std::size_t all = measures.views.size();
  const std::optional<double> alike = usual(measures, &ShapeViewMeasures::alike),
                              overlap = usual(measures, &ShapeViewMeasures::overlap);
  const auto is_strange = [&](const ShapeViewMeasures& view) {
    return alike && view.alike && *view.alike < kStrange * *alike;
  };
  const bool poses_off = measures.off_px && *measures.off_px >= kOff_px;
  if (measures.moved) return {moved(measures)};
  if (poses_off) {
    found.push_back(poses(*measures.off_px));
  } else {
    if (auto names = names_where(measures, is_strange); !names.empty()) found.push_back(strange(std::move(names)));
    if (overlap && *overlap < kUsualOverlap) {
      found.push_back(outlines_apart(*overlap));
    } else if (overlap) {
      auto names = names_where(measures, [&](const ShapeViewMeasures& view) {
        return view.overlap && *view.overlap < *overlap - kMisfit && !is_strange(view);
      });
      if (!names.empty()) found.push_back(misfits(std::move(names)));
    }
  }
  const std::size_t without =
      names_where(measures, [](const ShapeViewMeasures& view) { return !view.outlined; }).size();
  auto cut = names_where(measures, [](const ShapeViewMeasures& view) { return view.cut; });
  if (static_cast<double>(cut.size()) > kImagesCut * static_cast<double>(all))
    found.push_back(cut_by_frames(std::move(cut), all));
  const bool unbounded = static_cast<double>(without) > kFewOutlines * static_cast<double>(all);
  if (unbounded) found.push_back(background(without, all));
  if (!unbounded && measures.at_border >= kAtBorder) found.push_back(cut_off(measures.at_border));
  const bool far_apart = measures.angle_between > kFarApart && measures.sight.smooth >= kSmooth;
  // What is smooth comes out rough, and so hides some of itself.
  const bool one_sided = !unbounded && measures.sight.aside >= std::max(kAside, measures.sight.smooth);
  if (one_sided || far_apart) found.push_back(directions(measures, one_sided));
  if (measures.sight.smooth >= kSmooth && !far_apart && !poses_off) found.push_back(smooth(measures.sight.smooth));
  const auto thin_in = names_where(measures, [](const ShapeViewMeasures& view) { return view.thin_missing >= kThin; });
  if (!poses_off && static_cast<double>(thin_in.size()) > kImagesWithThin * static_cast<double>(all))
    found.push_back(thin(measures.cell_px));
  if (!unbounded && measures.sight.underneath >= kUnderneath) found.push_back(underside(measures.sight.underneath));
  return found;
}

}  // namespace sheen
