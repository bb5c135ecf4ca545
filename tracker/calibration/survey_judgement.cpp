// SPDX-License-Identifier: Apache-2.0
#include "tracker/calibration/survey_judgement.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "common/base/errors.h"
#include "common/base/format.h"
#include "tracker/pose/keyframe_gate.h"
#include "tracker/pose/reprojection.h"

namespace sheen {
namespace {

constexpr double kSigmas = 4;
constexpr double kLeastScale = 0.0005, kLeastShift_m = 0.3e-3, kLeastTilt_deg = 1, kLeastFocal = 0.001;
constexpr double kHuberPx = 1;
constexpr std::size_t kFewestForHalves = 10;  ///< images

/// A number that follows linearly from the corners, with its standard deviation.
struct Derived {
  double value = 0, sigma = 0;
  bool beyond(double least) const { return std::abs(value) > std::max(kSigmas * sigma, least); }
};

/// How much longer the sheet is along its axes than the similarity says, which makes it so on average: parts of it.
struct Stretch {
  Eigen::Vector3d by = Eigen::Vector3d::Zero();      ///< x, y, 0
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();  ///< of the sheet, about which
  Derived difference;                                ///< x less y
};

/// Least squares over the corners, tags weighted down that stand elsewhere (by iteration).
Stretch find_stretch(const StageSurvey& survey, const StageLayout& printed) {
  constexpr int kIterations = 30;
  const auto& tags = survey.stage.tags;
  std::vector<double> weights(tags.size(), 1);
  Stretch stretch;
  const Eigen::Index size = survey.covariance.rows();
  Eigen::VectorXd difference(size), place(size);
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    Eigen::Vector3d sheet_mean = Eigen::Vector3d::Zero(), found_mean = sheet_mean;
    double total = 0;
    for (std::size_t i = 0; i < tags.size(); ++i)
      for (std::size_t c = 0; c < 4; ++c) {
        sheet_mean += weights[i] * printed.find(tags[i].id)->corners_object[c];
        found_mean += weights[i] * tags[i].corners_object[c];
        total += weights[i];
      }
    sheet_mean /= total;
    found_mean /= total;
    Eigen::VectorXd along_x = Eigen::VectorXd::Zero(size), along_y = along_x;
    double xx = 0, yy = 0;
    for (std::size_t i = 0; i < tags.size(); ++i)
      for (std::size_t c = 0; c < 4; ++c) {
        const auto at = static_cast<Eigen::Index>(12 * i + 3 * c);
        const Eigen::Vector3d arm = printed.find(tags[i].id)->corners_object[c] - sheet_mean;
        place.segment<3>(at) = tags[i].corners_object[c];
        along_x[at] = weights[i] * arm.x();
        along_y[at + 1] = weights[i] * arm.y();
        xx += weights[i] * arm.x() * arm.x();
        yy += weights[i] * arm.y() * arm.y();
      }
    along_x /= survey.scale * xx;
    along_y /= survey.scale * yy;
    stretch.by = {along_x.dot(place) - 1, along_y.dot(place) - 1, 0};
    stretch.middle = sheet_mean;
    difference = along_x - along_y;
    for (std::size_t i = 0; i < tags.size(); ++i) {
      double farthest = kLeastShift_m;
      for (std::size_t c = 0; c < 4; ++c) {
        const Eigen::Vector3d arm = printed.find(tags[i].id)->corners_object[c] - sheet_mean;
        const Eigen::Vector3d fitted =
            survey.scale * arm.cwiseProduct(Eigen::Vector3d::Ones() + stretch.by) + found_mean;
        farthest = std::max(farthest, (tags[i].corners_object[c] - fitted).norm());
      }
      weights[i] = std::pow(kLeastShift_m / farthest, 2);
    }
  }
  stretch.difference = {stretch.by.x() - stretch.by.y(), std::sqrt(difference.dot(survey.covariance * difference))};
  return stretch;
}

/// `stretched_m`: how far the stretch of the whole sheet takes the tag.
void judge_tag(const SurveyedTag& tag, const Eigen::Vector3d& stretched_m, std::vector<SurveyFinding>& findings) {
  if (!tag.surveyed) {
    const bool unsteady = tag.disagreeing > 0;
    findings.push_back({unsteady ? SurveyFault::kUnsteadyTag : SurveyFault::kUnseenTag, tag.id,
                        format("tag %d is %s; it is not on the surveyed stage%s", tag.id, tag.reason.c_str(),
                               unsteady ? ": glue it down" : "")});
    return;
  }
  const auto beyond = [](double value, double sigma, double least) {
    return std::abs(value) > std::max(kSigmas * sigma, least);
  };
  const double aside = (tag.shift_m - stretched_m).head<2>().norm(), above = tag.shift_m.z();
  if (beyond(aside, tag.shift_uncertainty_m, kLeastShift_m) ||
      beyond(tag.turn_deg, tag.tilt_uncertainty_deg, kLeastTilt_deg))
    findings.push_back({SurveyFault::kMovedTag, tag.id,
                        format("tag %d stands %.2f mm from its place on the sheet, rotated by %.1f degrees; the survey "
                               "has its true place",
                               tag.id, 1e3 * aside, tag.turn_deg)});
  if (beyond(tag.tilt_deg, tag.tilt_uncertainty_deg, kLeastTilt_deg) ||
      beyond(above, tag.shift_uncertainty_m, kLeastShift_m))
    findings.push_back({SurveyFault::kTiltedTag, tag.id,
                        format("tag %d leans by %.1f degrees out of the sheet's plane and lies %.2f mm above it; the "
                               "survey has its true place",
                               tag.id, tag.tilt_deg, 1e3 * above)});
}

/// Pose from the tags of one image, but one.
std::optional<RefinedPose> pose_without(const Camera& camera, const StageSurvey& survey, int image, int left_out) {
  std::vector<Correspondence> points;
  for (const StageSurvey::Sighting& s : survey.sightings)
    if (s.image == image && s.tag != left_out)
      for (int c = 0; c < 4; ++c) points.push_back({survey.stage.tags[s.tag].corners_object[c], s.corners[c]});
  return refine_pose(camera, points, survey.images[image].camera_from_object, kHuberPx);
}

void leave_tags_out(const Camera& camera, const StageSurvey& survey, SurveyQuality& quality) {
  std::vector<double> squares(survey.stage.tags.size(), 0);
  std::vector<int> counts(survey.stage.tags.size(), 0);
  double all = 0;
  int count = 0;
  for (const StageSurvey::Sighting& s : survey.sightings) {
    const auto pose = pose_without(camera, survey, s.image, s.tag);
    if (!pose) continue;
    for (int c = 0; c < 4; ++c)
      if (const auto pixel = camera.project(pose->camera_from_object * survey.stage.tags[s.tag].corners_object[c])) {
        const double square = (*pixel - s.corners[c]).squaredNorm();
        squares[s.tag] += square;
        ++counts[s.tag];
        all += square;
        ++count;
      }
  }
  for (std::size_t i = 0; i < squares.size(); ++i)
    quality.left_out_px.push_back(counts[i] > 0 ? std::sqrt(squares[i] / counts[i]) : 0);
  quality.left_out_rms_px = count > 0 ? std::sqrt(all / count) : 0;
}

void compare_halves(const Camera& camera, const StageLayout& printed, std::span<const SurveyImage> images,
                    const MeasuredLength& length, const StageSurvey& survey, SurveyQuality& quality) {
  std::vector<SurveyImage> halves[2];
  std::size_t next = 0;
  for (std::size_t i = 0; i < images.size(); ++i)
    if (survey.images[i].used) halves[next++ % 2].push_back(images[i]);
  if (next < kFewestForHalves) return;
  std::optional<StageSurvey> found[2];
  for (int half = 0; half < 2; ++half) try {
      found[half] = survey_stage(camera, printed, halves[half], length);
    } catch (const Error&) {
      return;  // half the images do not show the tags of the length; the whole does
    }
  std::vector<Eigen::Vector3d> first, second;
  double variance = 0;
  for (std::size_t i = 0; i < found[0]->stage.tags.size(); ++i) {
    const StageTag& tag = found[0]->stage.tags[i];
    const StageTag* other = found[1]->stage.find(tag.id);
    if (!other) continue;
    first.insert(first.end(), tag.corners_object.begin(), tag.corners_object.end());
    second.insert(second.end(), other->corners_object.begin(), other->corners_object.end());
  }
  if (first.size() < 16) return;
  // The length's uncertainty is common to both and no difference: taken out with the scale.
  const double relative = length.uncertainty_m / length.metres;
  for (const auto& half : found) {
    double trace = half->covariance.trace(), arms = 0;
    for (const StageTag& tag : half->stage.tags)
      for (const Eigen::Vector3d& corner : tag.corners_object) arms += corner.squaredNorm();
    trace -= relative * relative * arms;
    variance += trace / (4 * double(half->stage.tags.size()));
  }
  const Similarity second_from_first = fit_similarity(first, second);
  double sum = 0;
  for (std::size_t i = 0; i < first.size(); ++i) sum += (second_from_first * first[i] - second[i]).squaredNorm();
  quality.halves_m = std::sqrt(sum / double(first.size()));
  quality.halves_expected_m = std::sqrt(variance);
}

/// Covariance of an object point's pixel, from that of the tags through the pose of this image.
Eigen::Matrix2d object_covariance(const Camera& camera, const StageSurvey& survey, int image,
                                  const Eigen::Vector3d& point) {
  const Rigid3& pose = survey.images[image].camera_from_object;
  const Eigen::Matrix3d rotation = pose.rotation.toRotationMatrix();
  Matrix6 normal = Matrix6::Zero();
  Eigen::MatrixXd pull = Eigen::MatrixXd::Zero(6, survey.covariance.rows());  // J_pose^T J_corner
  for (const StageSurvey::Sighting& s : survey.sightings) {
    if (s.image != image) continue;
    for (int c = 0; c < 4; ++c) {
      const auto projection = project_with_jacobian(camera, pose, survey.stage.tags[s.tag].corners_object[c]);
      if (!projection) continue;
      normal += projection->jacobian.transpose() * projection->jacobian;
      pull.block<6, 3>(0, 12 * s.tag + 3 * c) +=
          projection->jacobian.transpose() * projection->jacobian.rightCols<3>() * rotation;
    }
  }
  const auto seen = project_with_jacobian(camera, pose, point);
  if (!seen) return Eigen::Matrix2d::Zero();
  const Eigen::MatrixXd chain = seen->jacobian * normal.ldlt().solve(pull);
  return chain * survey.covariance * chain.transpose();
}

void measure_object(const Camera& camera, const StageSurvey& survey, SurveyQuality& quality) {
  const ObjectRegion region = object_region(survey.stage);
  for (const Eigen::Vector3d& point :
       {region.centre, Eigen::Vector3d(region.centre + region.radius_m * Eigen::Vector3d::UnitZ())}) {
    double pixels = 0, metres = 0;
    int count = 0;
    for (int image = 0; image < static_cast<int>(survey.images.size()); ++image) {
      if (!survey.images[image].used) continue;
      const double variance = object_covariance(camera, survey, image, point).trace();
      const double distance = (survey.images[image].camera_from_object * point).norm();
      pixels += variance;
      metres += variance * std::pow(distance / camera.fx, 2);
      ++count;
    }
    quality.object_px = std::max(quality.object_px, std::sqrt(pixels / count));
    quality.object_m = std::max(quality.object_m, std::sqrt(metres / count));
  }
}

}  // namespace

const char* to_string(SurveyFault fault) {
  switch (fault) {
    case SurveyFault::kPrintScale:
      return "print_scale";
    case SurveyFault::kStretched:
      return "stretched";
    case SurveyFault::kMovedTag:
      return "moved_tag";
    case SurveyFault::kTiltedTag:
      return "tilted_tag";
    case SurveyFault::kUnsteadyTag:
      return "unsteady_tag";
    case SurveyFault::kUnseenTag:
      return "unseen_tag";
    case SurveyFault::kFocalLength:
      return "focal_length";
  }
  return "?";
}

std::vector<SurveyFinding> judge_survey(const StageSurvey& survey, const StageLayout& printed,
                                        double focal_uncertainty) {
  std::vector<SurveyFinding> findings;
  const Derived focal{survey.focal_ratio - 1, std::hypot(survey.focal_uncertainty, focal_uncertainty)};
  if (focal.beyond(kLeastFocal)) {
    // What else looks wrong may be its doing.
    findings.push_back({SurveyFault::kFocalLength, -1,
                        format("the camera's focal length is %.2f %% too %s for these images (+- %.3f %%): focus or "
                               "zoom changed since it was calibrated, or it is another camera; calibrate again",
                               100 * std::abs(focal.value), focal.value > 0 ? "short" : "long", 100 * focal.sigma)});
    return findings;
  }
  const Derived scale{survey.scale - 1, survey.scale_uncertainty};
  if (scale.beyond(kLeastScale))
    findings.push_back({SurveyFault::kPrintScale, -1,
                        format("the sheet is %.2f %% of its size (+- %.3f %%): it was not printed at 100 %%, or the "
                               "length of --length is wrong; the survey has the length's scale",
                               100 * survey.scale, 100 * scale.sigma)});
  const Stretch stretch = find_stretch(survey, printed);
  const double uneven = stretch.difference.value;
  if (stretch.difference.beyond(kLeastScale))
    findings.push_back({SurveyFault::kStretched, -1,
                        format("the sheet is %.2f %% longer along %s than along %s (+- %.3f %%): the printer's feed; "
                               "the survey has its true shape",
                               100 * std::abs(uneven), uneven > 0 ? "x" : "y", uneven > 0 ? "y" : "x",
                               100 * stretch.difference.sigma)});
  for (const SurveyedTag& tag : survey.tags) {
    const auto& sheet = printed.find(tag.id)->corners_object;
    const Eigen::Vector3d arm = (sheet[0] + sheet[1] + sheet[2] + sheet[3]) / 4 - stretch.middle;
    judge_tag(tag, survey.scale * arm.cwiseProduct(stretch.by), findings);
  }
  return findings;
}

SurveyQuality measure_quality(const Camera& camera, const StageLayout& printed, std::span<const SurveyImage> images,
                              const MeasuredLength& length, const StageSurvey& survey) {
  SurveyQuality quality;
  leave_tags_out(camera, survey, quality);
  compare_halves(camera, printed, images, length, survey, quality);
  measure_object(camera, survey, quality);
  return quality;
}

}  // namespace sheen
