// SPDX-License-Identifier: Apache-2.0
#include "tracker/calibration/stage_survey.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <optional>

#include "common/base/angle.h"
#include "common/base/errors.h"
#include "common/base/order_statistics.h"
#include "common/base/quantity.h"
#include "tracker/calibration/bundle.h"
#include "tracker/calibration/survey_gauge.h"
#include "tracker/pose/pose_solver.h"

namespace sheen {
namespace {

constexpr double kRobustHuberPx = 0.5;
constexpr double kMedianToSigma = 1.17741;  ///< median length of a 2-D Gaussian error, in standard deviations
constexpr int kMostRounds = 6;
/// The printed layout may be off by centimetres and the focal length by percents: the first poses need only be a start.
constexpr PoseOptions kStartPose{.min_tags = 3, .huber_px = 2, .drop_floor_px = 5, .max_rms_px = 40};

/// A tag in an image.
struct TagSighting {
  int image = 0, tag = 0;  ///< indices
  std::array<Eigen::Vector2d, 4> corners;
  bool good = true;
};

struct Workplace {
  Camera camera;
  const StageLayout& printed;
  const SurveyOptions& options;
  std::vector<SurveyedImage> images;
  std::vector<SurveyedTag> tags;  ///< in the order of `printed`
  std::vector<TagSighting> sightings;
  std::vector<Eigen::Vector3d> corners;  ///< four a tag of `printed`, as far as it is known
};

Workplace begin(const Camera& camera, const StageLayout& printed, std::span<const SurveyImage> images,
                const SurveyOptions& options) {
  Workplace work{camera, printed, options, {}, {}, {}, {}};
  for (const StageTag& tag : printed.tags) {
    work.tags.push_back({.id = tag.id, .surveyed = true});
    work.corners.insert(work.corners.end(), tag.corners_object.begin(), tag.corners_object.end());
  }
  for (const SurveyImage& image : images) {
    SurveyedImage seen{.name = image.name};
    std::vector<TagObservation> tags = image.tags;
    const PoseEstimate pose = solve_pose(camera, printed, tags, kStartPose);
    std::map<int, int> times_seen;
    for (const TagObservation& tag : tags) ++times_seen[tag.id];
    for (const TagObservation& tag : tags)
      if (const StageTag* known = printed.find(tag.id); known && times_seen[tag.id] == 1) {
        ++seen.tags;
        if (pose.usable())
          work.sightings.push_back(
              {static_cast<int>(work.images.size()), static_cast<int>(known - printed.tags.data()), tag.corners});
      }
    seen.camera_from_object = pose.camera_from_object;
    seen.used = pose.usable();
    if (seen.tags < options.fewest_tags)
      seen.reason = "only " + std::to_string(seen.tags) + " tags of the stage were found";
    else if (!seen.used)
      seen.reason = std::string("no pose: ") + to_string(pose.status);
    seen.used = seen.reason.empty();
    work.images.push_back(std::move(seen));
  }
  return work;
}

/// Images and tags in use as a bundle, and where each of its views and points stands in the workplace.
struct Numbering {
  std::vector<int> image_of_view, tag_of_block, view_of_image, block_of_tag;
};

Bundle bundle_of(const Workplace& work, Numbering& numbering) {
  numbering = {};
  numbering.view_of_image.assign(work.images.size(), -1);
  numbering.block_of_tag.assign(work.tags.size(), -1);
  Bundle bundle{.camera = work.camera, .free = {.points = true}};
  for (std::size_t i = 0; i < work.images.size(); ++i)
    if (work.images[i].used) {
      numbering.view_of_image[i] = static_cast<int>(numbering.image_of_view.size());
      numbering.image_of_view.push_back(static_cast<int>(i));
      bundle.camera_from_object.push_back(work.images[i].camera_from_object);
    }
  for (std::size_t i = 0; i < work.tags.size(); ++i)
    if (work.tags[i].surveyed) {
      numbering.block_of_tag[i] = static_cast<int>(numbering.tag_of_block.size());
      numbering.tag_of_block.push_back(static_cast<int>(i));
      bundle.points.insert(bundle.points.end(), &work.corners[4 * i], &work.corners[4 * i] + 4);
    }
  for (const TagSighting& s : work.sightings) {
    const int view = numbering.view_of_image[s.image], block = numbering.block_of_tag[s.tag];
    if (!s.good || view < 0 || block < 0) continue;
    for (int corner = 0; corner < 4; ++corner)
      bundle.sightings.push_back({view, 4 * block + corner, s.corners[corner]});
  }
  return bundle;
}

void take(Workplace& work, const Bundle& bundle, const Numbering& numbering) {
  for (std::size_t view = 0; view < numbering.image_of_view.size(); ++view)
    work.images[numbering.image_of_view[view]].camera_from_object = bundle.camera_from_object[view];
  for (std::size_t block = 0; block < numbering.tag_of_block.size(); ++block)
    for (int corner = 0; corner < 4; ++corner)
      work.corners[4 * numbering.tag_of_block[block] + corner] = bundle.points[4 * block + corner];
}

/// RMS of a tag's corners in an image.
double error_of(const Workplace& work, const TagSighting& s) {
  double sum = 0;
  for (int corner = 0; corner < 4; ++corner) {
    const auto pixel = work.camera.project(work.images[s.image].camera_from_object * work.corners[4 * s.tag + corner]);
    sum += pixel ? (*pixel - s.corners[corner]).squaredNorm() : INFINITY;
  }
  return std::sqrt(sum / 4);
}

/// Leaves out what cannot be estimated: images with too few tags, tags in too few images, until nothing changes.
void drop_what_is_seen_too_little(Workplace& work) {
  const SurveyOptions& options = work.options;
  for (bool changed = true; changed;) {
    changed = false;
    std::vector<int> tags_of(work.images.size(), 0), images_of(work.tags.size(), 0);
    for (const TagSighting& s : work.sightings)
      if (s.good && work.images[s.image].used && work.tags[s.tag].surveyed) {
        ++tags_of[s.image];
        ++images_of[s.tag];
      }
    for (std::size_t i = 0; i < work.images.size(); ++i)
      if (work.images[i].used && tags_of[i] < options.fewest_tags) {
        work.images[i].used = false;
        work.images[i].reason = "only " + std::to_string(tags_of[i]) + " of its tags agree with the other images";
        changed = true;
      }
    for (std::size_t i = 0; i < work.tags.size(); ++i) {
      work.tags[i].images = images_of[i];
      if (work.tags[i].surveyed && images_of[i] < options.fewest_sightings) {
        work.tags[i].surveyed = false;
        work.tags[i].reason = "seen in " + std::to_string(images_of[i]) + " images only";
        changed = true;
      }
    }
  }
}

/// Standard deviation of a corner's coordinate, whatever some tags do.
double robust_noise(const Workplace& work) {
  std::vector<double> errors;
  for (const TagSighting& s : work.sightings)
    if (work.images[s.image].used && work.tags[s.tag].surveyed) errors.push_back(error_of(work, s));
  return median(errors) / kMedianToSigma;
}

/// Judges every sighting again. Whether anything changed.
bool judge(Workplace& work) {
  const double limit = std::max(work.options.outlier_sigmas * robust_noise(work), work.options.outlier_floor_px);
  bool changed = false;
  std::vector<int> seen(work.tags.size(), 0), off(work.tags.size(), 0);
  for (TagSighting& s : work.sightings) {
    if (!work.images[s.image].used || !work.tags[s.tag].surveyed) continue;
    const bool good = error_of(work, s) <= limit;
    changed = changed || good != s.good;
    s.good = good;
    ++seen[s.tag];
    off[s.tag] += !good;
  }
  for (std::size_t i = 0; i < work.tags.size(); ++i) {
    SurveyedTag& tag = work.tags[i];
    if (!tag.surveyed) continue;
    tag.disagreeing = off[i];
    if (off[i] < 2 || off[i] <= work.options.most_disagreeing * seen[i]) continue;
    tag.surveyed = false;
    tag.reason =
        "not in one place: elsewhere in " + std::to_string(off[i]) + " of " + std::to_string(seen[i]) + " images";
    changed = true;
  }
  return changed;
}

int block_of(const Numbering& numbering, const Workplace& work, int id) {
  for (std::size_t i = 0; i < work.tags.size(); ++i)
    if (work.tags[i].id == id && numbering.block_of_tag[i] >= 0) return numbering.block_of_tag[i];
  throw Error("--length names tag " + std::to_string(id) +
              ", which could not be surveyed; measure between two tags that the images show well");
}

/// Moves everything into the frame of the sheet, with the length's scale. The sheet's scale is returned.
double settle(Bundle& bundle, std::span<const Eigen::Vector3d> sheet, std::vector<double>& weights, int from, int to,
              double metres) {
  const double factor =
      metres / (middle_of_tag(&bundle.points[4 * to]) - middle_of_tag(&bundle.points[4 * from])).norm();
  for (Eigen::Vector3d& point : bundle.points) point *= factor;
  for (Rigid3& pose : bundle.camera_from_object) pose.translation *= factor;
  const Similarity fit = robust_similarity(sheet, bundle.points, weights);
  const Rigid3 found_from_sheet{Eigen::Quaterniond(fit.rotation), fit.translation};
  const Rigid3 sheet_from_found = found_from_sheet.inverse();
  for (Eigen::Vector3d& point : bundle.points) point = sheet_from_found * point;
  for (Rigid3& pose : bundle.camera_from_object) pose = pose * found_from_sheet;
  return fit.scale;
}

void describe(SurveyedTag& tag, const Eigen::Vector3d* corners, const Eigen::Vector3d* sheet, double scale,
              const Eigen::Matrix<double, 12, 12>& covariance) {
  tag.shift_m = middle_of_tag(corners) - scale * middle_of_tag(sheet);
  const Eigen::Vector3d right = corners[1] + corners[2] - corners[0] - corners[3];
  const Eigen::Vector3d up = corners[0] + corners[1] - corners[2] - corners[3];
  const Eigen::Vector3d sheet_right = sheet[1] + sheet[2] - sheet[0] - sheet[3];
  const Eigen::Vector3d sheet_up = sheet[0] + sheet[1] - sheet[2] - sheet[3];
  const Eigen::Vector3d normal = right.cross(up).normalized(), sheet_normal = sheet_right.cross(sheet_up).normalized();
  tag.tilt_deg = std::acos(std::clamp(normal.dot(sheet_normal), -1.0, 1.0)) / kDegree;
  tag.turn_deg = std::atan2(sheet_normal.dot(sheet_right.cross(right)), sheet_right.dot(right)) / kDegree;
  Eigen::Matrix<double, 3, 12> mean;
  Eigen::Matrix<double, 1, 12> lean_right = Eigen::Matrix<double, 1, 12>::Zero(), lean_up = lean_right;
  for (int c = 0; c < 4; ++c) {
    mean.block<3, 3>(0, 3 * c) = Eigen::Matrix3d::Identity() / 4;
    lean_right.segment<3>(3 * c) = (c == 1 || c == 2 ? 1 : -1) * sheet_normal.transpose() / right.norm();
    lean_up.segment<3>(3 * c) = (c < 2 ? 1 : -1) * sheet_normal.transpose() / up.norm();
  }
  tag.shift_uncertainty_m = std::sqrt((mean * covariance * mean.transpose()).eval().diagonal().maxCoeff());
  tag.tilt_uncertainty_deg = std::sqrt(std::max((lean_right * covariance * lean_right.transpose())(0, 0),
                                                (lean_up * covariance * lean_up.transpose())(0, 0))) /
                             kDegree;
}

double squared_sum(const Bundle& bundle) {
  double sum = 0;
  for (const Eigen::Vector2d& r : residuals(bundle)) sum += r.squaredNorm();
  return sum;
}

/// The ratio of the focal length that fits best to the one given, and its standard deviation.
std::pair<double, double> focal_ratio(Bundle bundle, std::span<const Eigen::Vector3d> sheet, double metres, int from,
                                      int to) {
  const double given = bundle.camera.fx;
  bundle.free.intrinsics = {true};
  solve(bundle);
  std::vector<double> weights;
  settle(bundle, sheet, weights, from, to, metres);
  const double unknowns = 1 + 6.0 * double(bundle.camera_from_object.size()) + 3.0 * double(bundle.points.size()) - 7;
  const double variance = squared_sum(bundle) / (2.0 * double(bundle.sightings.size()) - unknowns);
  const int first = 1 + 6 * static_cast<int>(bundle.camera_from_object.size());
  const Eigen::MatrixXd inverse =
      constrained_inverse(information(bundle), gauge(bundle.points, sheet, weights, from, to), first);
  return {bundle.camera.fx / given, std::sqrt(variance * inverse(0, 0)) / given};
}

}  // namespace

MeasuredLength parse_measured_length(const std::string& text) {
  constexpr const char* kTakes = "a length, as \"tag 3 to tag 7: 200mm\" or \"tag 3 to tag 7: 200mm +- 0.1mm\"";
  MeasuredLength length;
  int used = 0;
  if (std::sscanf(text.c_str(), "tag %d to tag %d:%n", &length.from_tag, &length.to_tag, &used) != 2 || used == 0)
    throw ConfigError("--length \"" + text + "\": takes " + kTakes);
  const auto trimmed = [](const std::string& word) {
    const std::size_t first = word.find_first_not_of(' ');
    return first == std::string::npos ? std::string() : word.substr(first, word.find_last_not_of(' ') + 1 - first);
  };
  const std::string rest = text.substr(static_cast<std::size_t>(used));
  const std::size_t sign = rest.find("+-");
  length.metres = parse_length_m("--length", trimmed(rest.substr(0, sign)), kTakes);
  if (sign != std::string::npos)
    length.uncertainty_m = parse_length_m("--length", trimmed(rest.substr(sign + 2)), kTakes);
  if (length.from_tag == length.to_tag)
    throw ConfigError("--length \"" + text + "\": the tags must be two; takes " + kTakes);
  return length;
}

StageSurvey survey_stage(const Camera& camera, const StageLayout& printed, std::span<const SurveyImage> images,
                         const MeasuredLength& length, const SurveyOptions& options) {
  for (const int id : {length.from_tag, length.to_tag})
    if (!printed.find(id)) throw Error("--length names tag " + std::to_string(id) + ", which is not on the stage");
  Workplace work = begin(camera, printed, images, options);
  Numbering numbering;
  Bundle bundle;
  const auto refit = [&](double huber_px) {
    drop_what_is_seen_too_little(work);
    const auto used = std::ranges::count_if(work.images, [](const SurveyedImage& image) { return image.used; });
    const auto tags = std::ranges::count_if(work.tags, [](const SurveyedTag& tag) { return tag.surveyed; });
    if (used < options.fewest_images || tags < options.fewest_tags)
      throw Error("only " + std::to_string(used) + " images and " + std::to_string(tags) +
                  " tags can be used; a survey needs " + std::to_string(options.fewest_images) +
                  " images or more of the same stage, sharp and from different sides");
    bundle = bundle_of(work, numbering);
    solve(bundle, huber_px);
    take(work, bundle, numbering);
  };
  refit(kRobustHuberPx);
  // A tag that stood elsewhere in some images pulls its place by the loss's width, which must be within the noise.
  refit(std::max(2 * robust_noise(work), options.outlier_floor_px / 4));
  for (int round = 0; round < kMostRounds && judge(work); ++round) refit(0);
  refit(0);

  const int from = block_of(numbering, work, length.from_tag), to = block_of(numbering, work, length.to_tag);
  std::vector<Eigen::Vector3d> sheet;
  for (const int tag : numbering.tag_of_block)
    sheet.insert(sheet.end(), printed.tags[tag].corners_object.begin(), printed.tags[tag].corners_object.end());
  StageSurvey survey;
  std::vector<double> weights;
  survey.scale = settle(bundle, sheet, weights, from, to, length.metres);
  take(work, bundle, numbering);

  const double unknowns = 6.0 * double(bundle.camera_from_object.size()) + 3.0 * double(bundle.points.size()) - 7;
  const double values = 2.0 * double(bundle.sightings.size());
  if (values <= unknowns) throw Error("the images show too few tags to survey the stage; take more");
  const double squares = squared_sum(bundle);
  survey.rms_px = std::sqrt(2 * squares / values);
  survey.noise_px = std::sqrt(squares / (values - unknowns));
  const int first = 6 * static_cast<int>(bundle.camera_from_object.size());
  const int size = 3 * static_cast<int>(bundle.points.size());
  const Eigen::MatrixXd inverse =
      constrained_inverse(information(bundle), gauge(bundle.points, sheet, weights, from, to), first);
  survey.covariance = survey.noise_px * survey.noise_px * inverse.bottomRightCorner(size, size);
  const double relative = length.uncertainty_m / length.metres;
  const Eigen::Map<const Eigen::VectorXd> place(bundle.points[0].data(), size);
  survey.covariance += relative * relative * place * place.transpose();
  const Eigen::Map<const Eigen::VectorXd> arm(sheet[0].data(), size);  // about the middle of the sheet
  survey.scale_uncertainty = std::sqrt(arm.dot(survey.covariance * arm)) / arm.squaredNorm();
  std::tie(survey.focal_ratio, survey.focal_uncertainty) = focal_ratio(bundle, sheet, length.metres, from, to);

  survey.stage = {printed.family, survey.scale * printed.width_m, survey.scale * printed.height_m, {}};
  for (std::size_t block = 0; block < numbering.tag_of_block.size(); ++block) {
    SurveyedTag& tag = work.tags[numbering.tag_of_block[block]];
    describe(tag, &bundle.points[4 * block], &sheet[4 * block], survey.scale,
             survey.covariance.block<12, 12>(12 * Eigen::Index(block), 12 * Eigen::Index(block)));
    StageTag placed{.id = tag.id};
    std::copy_n(&bundle.points[4 * block], 4, placed.corners_object.begin());
    survey.stage.tags.push_back(placed);
  }
  std::vector<double> image_squares(work.images.size(), 0), tag_squares(work.tags.size(), 0);
  std::vector<int> image_count(work.images.size(), 0);
  for (const TagSighting& s : work.sightings) {
    if (!s.good || !work.images[s.image].used || !work.tags[s.tag].surveyed) continue;
    const double square = std::pow(error_of(work, s), 2);
    image_squares[s.image] += square;
    ++image_count[s.image];
    tag_squares[s.tag] += square;
    survey.sightings.push_back({s.image, numbering.block_of_tag[s.tag], s.corners});
  }
  for (std::size_t i = 0; i < work.images.size(); ++i)
    if (image_count[i] > 0) work.images[i].rms_px = std::sqrt(image_squares[i] / image_count[i]);
  for (std::size_t i = 0; i < work.tags.size(); ++i)
    if (work.tags[i].surveyed) work.tags[i].rms_px = std::sqrt(tag_squares[i] / work.tags[i].images);
  survey.images = std::move(work.images);
  survey.tags = std::move(work.tags);
  return survey;
}

}  // namespace sheen
