// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/studies/shadow_warp.h"

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <opencv2/core/eigen.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>
#include <optional>

#include "reconstructor/lumigraph_file/depth_points.h"

namespace sheen {
namespace {

constexpr float kTear = 6;       // sizes of a pixel on the surface, in depth
constexpr int kSmallest = 12;    // pixels of a blob that is followed
constexpr int kReach = 3;        // pixels round a geometric blob that belong to it
constexpr double kJoined = 1.4;  // times as large, or as small: the blob was joined to another, or came apart
constexpr int kSteps = 40;       // of a registration
constexpr double kEnough = 1e-4;
constexpr int kBlur = 7;  // pixels, of the masks that are registered

cv::Mat matrix_of(const ImageU8& image) {
  return {image.height(), image.width(), CV_8UC1, const_cast<std::uint8_t*>(image.data())};
}

struct Blob {
  cv::Mat mask;     ///< 255 within, of the whole picture's size
  double area = 0;  ///< pixels
  Eigen::Vector2d centroid = Eigen::Vector2d::Zero();
  Eigen::Matrix2d spread = Eigen::Matrix2d::Identity();  ///< second central moments, square pixels
};

std::vector<Blob> blobs_of(const cv::Mat& mask) {
  cv::Mat labels, numbers, centroids;
  const int count = cv::connectedComponentsWithStats(mask, labels, numbers, centroids);
  std::vector<Blob> blobs;
  for (int i = 1; i < count; ++i) {
    if (numbers.at<int>(i, cv::CC_STAT_AREA) < kSmallest) continue;
    Blob& blob = blobs.emplace_back(Blob{.mask = labels == i});
    const cv::Moments m = cv::moments(blob.mask, /*binaryImage=*/true);
    blob.area = m.m00;
    constexpr double kPixel = 1.0 / 12;  // the spread of a pixel itself: a line has one as well
    blob.centroid = {m.m10 / m.m00, m.m01 / m.m00};
    blob.spread << m.mu20 / m.m00 + kPixel, m.mu11 / m.m00, m.mu11 / m.m00, m.mu02 / m.m00 + kPixel;
  }
  return blobs;
}

using Eigen::Affine2d;  // of the picture's plane

cv::Mat moved(const cv::Mat& mask, const Affine2d& map) {
  cv::Mat matrix, out;
  cv::eigen2cv(Eigen::Matrix<double, 2, 3>(map.affine()), matrix);
  cv::warpAffine(mask, out, matrix, mask.size(), cv::INTER_LINEAR);
  return out;
}

double overlap(const cv::Mat& a, const cv::Mat& b) {
  cv::Mat both, either;
  cv::min(a, b, both);
  cv::max(a, b, either);
  const double all = cv::sum(either)[0];
  return all > 0 ? cv::sum(both)[0] / all : 0;
}

/// Brings the moments of one blob to those of the other, without a turn that they do not tell of.
Affine2d by_moments(const Blob& from, const Blob& to) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> a(from.spread), b(to.spread);
  Affine2d map = Affine2d::Identity();
  map.linear() = b.operatorSqrt() * a.operatorInverseSqrt();
  map.translation() = to.centroid - map.linear() * from.centroid;
  return map;
}

/// The same refined by correlation; nothing where it does not converge.
std::optional<Affine2d> by_correlation(const Blob& from, const Blob& to, const Affine2d& start) {
  cv::Mat target, source, matrix;
  to.mask.convertTo(target, CV_32F, 1 / 255.0);
  from.mask.convertTo(source, CV_32F, 1 / 255.0);
  // The library looks for the map from the target's pixels to the source's.
  cv::eigen2cv(Eigen::Matrix<float, 2, 3>(start.inverse().affine().cast<float>()), matrix);
  try {
    cv::findTransformECC(target, source, matrix, cv::MOTION_AFFINE,
                         cv::TermCriteria(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, kSteps, kEnough), {}, kBlur);
  } catch (const cv::Exception&) {
    return std::nullopt;
  }
  Eigen::Matrix<double, 2, 3> numbers;
  cv::cv2eigen(matrix, numbers);
  Affine2d found = Affine2d::Identity();
  found.affine() = numbers;
  if (!numbers.allFinite() || std::abs(found.linear().determinant()) < 1e-3) return std::nullopt;
  return found.inverse();
}

/// One that is joined to another on this step, or comes apart, has no affine map: it stays where it is.
Affine2d registered(const Blob& from, const Blob& to) {
  if (std::max(from.area / to.area, to.area / from.area) > kJoined) return Affine2d::Identity();
  const Affine2d moments = by_moments(from, to);
  const std::optional<Affine2d> refined = by_correlation(from, to, moments);
  return refined && overlap(moved(from.mask, *refined), to.mask) > overlap(moved(from.mask, moments), to.mask)
             ? *refined
             : moments;
}

/// What a blob becomes among those of the next light; none where there are none.
const Blob* next_of(const Blob& blob, const std::vector<Blob>& blobs) {
  const Blob* best = nullptr;
  double most = 0, nearest = 1e30;
  for (const Blob& other : blobs) {
    const double shared = overlap(blob.mask, other.mask), distance = (blob.centroid - other.centroid).norm();
    if (shared > most || (most == 0 && shared == 0 && distance < nearest)) best = &other;
    most = std::max(most, shared);
    nearest = std::min(nearest, distance);
  }
  return best;
}

/// Shadows of the image in the first light of a row, as they are in each of its lights.
std::vector<cv::Mat> followed(const std::vector<std::vector<Blob>>& row, const cv::Mat& image_mask) {
  std::vector<cv::Mat> shadows;
  for (std::size_t k = 0; k < row.size(); ++k) shadows.push_back(cv::Mat::zeros(image_mask.size(), CV_8UC1));
  const cv::Mat reach = cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * kReach + 1, 2 * kReach + 1});
  for (const Blob& blob : row.front()) {
    cv::Mat attached;
    cv::dilate(blob.mask, attached, reach);
    cv::min(attached, image_mask, attached);
    Affine2d map = Affine2d::Identity();
    const Blob* at = &blob;
    for (std::size_t k = 0; k < row.size(); ++k) {
      if (k > 0) {
        const Blob* next = next_of(*at, row[k]);
        if (!next) break;
        map = registered(*at, *next) * map;
        at = next;
      }
      cv::max(shadows[k], moved(attached, map), shadows[k]);
    }
  }
  return shadows;
}

}  // namespace

Mesh depth_surface(const PosedCamera& from, const ImageF& depth) {
  const DepthPoints points(from);
  const int w = depth.width(), h = depth.height();
  Mesh mesh;
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) mesh.vertices.push_back(points.at(x, y, depth.at(x, y)));
  const float pixel = static_cast<float>(1 / std::min(from.camera.fx, from.camera.fy));  // per metre of depth
  const auto joined = [&](const std::array<Eigen::Vector2i, 3>& corners) {
    float near = 1e30f, far = 0;
    for (const Eigen::Vector2i& corner : corners) {
      near = std::min(near, depth.at(corner.x(), corner.y()));
      far = std::max(far, depth.at(corner.x(), corner.y()));
    }
    return near > 0 && far - near < kTear * pixel * near;
  };
  const auto add = [&](const std::array<Eigen::Vector2i, 3>& corners) {
    if (!joined(corners)) return;
    Triangle triangle;
    for (std::size_t c = 0; c < 3; ++c) triangle[c] = static_cast<std::uint32_t>(corners[c].y() * w + corners[c].x());
    mesh.triangles.push_back(triangle);
  };
  for (int y = 0; y + 1 < h; ++y)
    for (int x = 0; x + 1 < w; ++x) {
      add({{{x, y}, {x, y + 1}, {x + 1, y}}});
      add({{{x + 1, y}, {x, y + 1}, {x + 1, y + 1}}});
    }
  return mesh;
}

std::vector<ImageU8> warped_shadows(std::span<const ImageU8> geometric, const ImageU8& first, const ImageU8& last) {
  std::vector<std::vector<Blob>> row;
  for (const ImageU8& mask : geometric) row.push_back(blobs_of(matrix_of(mask) >= 128));
  const std::vector<cv::Mat> forward = followed(row, matrix_of(first));
  std::reverse(row.begin(), row.end());
  std::vector<cv::Mat> backward = followed(row, matrix_of(last));
  std::reverse(backward.begin(), backward.end());
  std::vector<ImageU8> shadows;
  for (std::size_t k = 0; k < forward.size(); ++k) {
    const double part = static_cast<double>(k) / static_cast<double>(forward.size() - 1);
    ImageU8& shadow = shadows.emplace_back(first.width(), first.height(), 1);
    cv::Mat out = matrix_of(shadow);
    cv::addWeighted(forward[k], 1 - part, backward[k], part, 0, out);
  }
  return shadows;
}

}  // namespace sheen
