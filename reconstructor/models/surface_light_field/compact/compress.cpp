// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/compact/compress.h"

#include <malloc.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <random>
#include <string>
#include <utility>

#include "common/base/errors.h"
#include "common/geometry/ray_scene.h"
#include "common/image/color.h"
#include "reconstructor/coding/step_search.h"
#include "reconstructor/light_field_file/encode/light_field_encoding.h"
#include "reconstructor/light_field_file/light_field_file.h"
#include "reconstructor/models/surface_light_field/compact/fit_patches.h"

namespace sheen {
namespace {

constexpr std::size_t kMostCameras = UINT16_MAX;  // views name theirs by 16 bits in a file

constexpr std::size_t kEyes = 12, kRaysPerEye = 40000;

/// A point of the surface as both forms of the light field have it.
struct SurfacePoint {
  std::uint32_t triangle = 0, old_triangle = 0;
  float u = 0, v = 0, old_u = 0, old_v = 0;
  Eigen::Vector3f encoded = Eigen::Vector3f::Zero();  ///< colour of the exact form
};

/// What is lost is looked for at points in sight of eyes that lie between two cameras each.
class LossMeter {
 public:
  LossMeter(const SurfaceLightFieldSnapshot& exact, const CanonicalMesh& mesh) {
    const std::vector<PosedCamera>& cameras = exact.cameras();
    std::mt19937 random(1);
    const RayScene scene(*mesh.mesh);
    const std::size_t stride = std::max<std::size_t>(1, cameras.size() / kEyes);
    for (std::size_t i = 0; i < cameras.size(); i += stride) add_eye(between(cameras, i), exact, mesh, scene, random);
    predicted_ /= static_cast<double>(std::max<std::size_t>(points_, 1));
  }

  /// Mean square of encoded values.
  double loss(const CompactLightField& compact) const {
    double sum = 0;
    for (const Sight& sight : sights_) {
      const auto shader = compact.shader_for({sight.eye});
      for (const SurfacePoint& point : sight.points)
        sum += (encoded(shader->shade(point.triangle, point.u, point.v).rgb) - point.encoded).squaredNorm() / 3;
    }
    return sum / static_cast<double>(std::max<std::size_t>(points_, 1));
  }
  /// Mean square error that the light field itself predicts of its pictures.
  double predicted_error() const { return predicted_; }

 private:
  struct Sight {
    Eigen::Vector3d eye;
    std::vector<SurfacePoint> points;
  };

  static Eigen::Vector3f encoded(const Eigen::Vector3f& radiance) {
    return radiance.unaryExpr([](float value) { return std::clamp(srgb_encode(value), 0.0f, 1.0f); });
  }

  static Eigen::Vector3d between(const std::vector<PosedCamera>& cameras, std::size_t i) {
    const Eigen::Vector3d eye = camera_centre(cameras[i].camera_from_object);
    Eigen::Vector3d nearest = eye;
    double distance = INFINITY;
    for (std::size_t j = 0; j < cameras.size(); ++j) {
      const Eigen::Vector3d other = camera_centre(cameras[j].camera_from_object);
      if (j == i || (other - eye).norm() > distance || other == eye) continue;
      distance = (other - eye).norm();
      nearest = other;
    }
    return (eye + nearest) / 2;
  }

  /// Where random rays from the eye meet the front of what some image showed.
  void add_eye(const Eigen::Vector3d& eye, const SurfaceLightFieldSnapshot& exact, const CanonicalMesh& mesh,
               const RayScene& scene, std::mt19937& random) {
    const BoundingSphere bounds = bounding_sphere(*mesh.mesh);
    std::uniform_real_distribution<double> uniform(-1, 1);
    const auto shader = exact.shader_for({eye});
    Sight sight{.eye = eye};
    for (std::size_t i = 0; i < kRaysPerEye; ++i) {
      const Eigen::Vector3d target =
          bounds.centre + bounds.radius * Eigen::Vector3d::NullaryExpr([&] { return uniform(random); });
      const Hit hit = scene.intersect({eye.cast<float>(), (target - eye).cast<float>()});
      if (!hit || !hit.front) continue;
      SurfacePoint point{.triangle = hit.triangle, .u = hit.u, .v = hit.v};
      point.old_triangle = mesh.old_triangle[point.triangle];
      const float weight[3] = {1 - point.u - point.v, point.u, point.v};
      float old[3];
      for (int c = 0; c < 3; ++c) old[(c + mesh.first_corner[point.triangle]) % 3] = weight[c];
      point.old_u = old[1];
      point.old_v = old[2];
      const SurfaceSample sample = shader->shade(point.old_triangle, point.old_u, point.old_v);
      if (sample.state == SampleState::kUnseen) continue;
      point.encoded = encoded(sample.rgb);
      const double error = shader->quality(point.old_triangle).error;
      predicted_ += error * error;
      sight.points.push_back(point);
    }
    points_ += sight.points.size();
    sights_.push_back(std::move(sight));
  }

  std::vector<Sight> sights_;
  std::size_t points_ = 0;
  double predicted_ = 0;
};

class LightFieldCompression : public Compression {
 public:
  LightFieldCompression(const SurfaceLightFieldSnapshot& exact, CompressionTarget target)
      : target_(std::move(target)),
        mesh_(canonical_mesh(exact.mesh())),
        psnr_db_(target_.judge ? target_.judge(exact) : std::numeric_limits<double>::quiet_NaN()),
        model_(fit_patches(exact, mesh_, least_rms(std::isfinite(psnr_db_) ? psnr_db_ : target_.psnr_db),
                           kPatchTriangles)) {
    if (!std::isfinite(psnr_db_)) meter_.emplace(exact, mesh_);
  }

  CompressedModel run() override { return target_.bytes ? within_bytes(*target_.bytes) : within_loss(target_.loss_db); }

 private:
  // In larger patches the coefficients cost less and the maps more.
  static constexpr std::size_t kPatchTriangles = 8;

  /// Terms that are fainter, in grey levels, are lost at any step that anybody asks for: a part of the error that the
  /// pictures have anyway.
  static double least_rms(double psnr_db) {
    constexpr double kPart = 0.04, kLeast = 0.04, kMost = 0.4;
    return std::isfinite(psnr_db) ? std::clamp(kPart * 255 * std::pow(10, -psnr_db / 20), kLeast, kMost) : kMost;
  }

  /// Which is the better one differs: faint terms are worth their bytes where detail moves with the view, fine detail
  /// is where it does not. Both are tried.
  static constexpr Rounding kRoundings[] = {{.bit_price = 0.12f, .least_term = 0.12f},
                                            {.bit_price = 0.08f, .least_term = 0.25f}};
  static constexpr double kFirstStep = 8, kFinestStep = 0.1, kCoarsestStep = 100;

  std::shared_ptr<const std::string> encoded(double step, const Rounding& rounding) {
    if (target_.progress) target_.progress(tries_++, std::size(kRoundings) * StepSearch::kMostTries);
    malloc_trim(0);  // what the try before took lies scattered
    auto file = std::make_shared<const std::string>(
        encode_light_field(model_, mesh_, static_cast<float>(step), rounding, in_parallel));
    malloc_trim(0);
    return file;
  }

  /// The best file so far. Only one is open at a time, which takes many times its bytes.
  struct Best {
    std::shared_ptr<const std::string> file;
    double loss_db = 0;

    CompressedModel opened() const { return {open(file), loss_db, file->size()}; }
  };

  CompressedModel within_bytes(double bytes) {
    Best best;
    std::size_t least = 0;
    double first_step = kFirstStep;
    for (const Rounding& rounding : kRoundings) {
      StepSearch search(bytes, -0.9, first_step, kFinestStep, kCoarsestStep);
      std::shared_ptr<const std::string> largest;
      bool more = true;
      while (more) {
        auto candidate = encoded(search.step(), rounding);
        const std::size_t size = candidate->size();
        first_step = search.step();
        more = search.next(static_cast<double>(size));
        if (least == 0 || size < least) least = size;
        if (static_cast<double>(size) <= bytes && (!largest || size > largest->size())) largest = std::move(candidate);
      }
      if (!largest) continue;
      const double loss = loss_of(*open(largest));
      if (!best.file || loss < best.loss_db) best = {std::move(largest), loss};
    }
    if (!best.file)
      throw ConfigError("the model does not fit into " + std::to_string(static_cast<std::size_t>(bytes)) +
                        " bytes: the least that was reached is " + std::to_string(least));
    return best.opened();
  }

  CompressedModel within_loss(double loss_db) {
    Best best;
    double first_step = kFirstStep;
    for (const Rounding& rounding : kRoundings) {
      StepSearch search(loss_db, 1.2, first_step, kFinestStep, kCoarsestStep);
      bool more = true;
      while (more) {
        auto candidate = encoded(search.step(), rounding);
        const double loss = loss_of(*open(candidate));
        first_step = search.step();
        more = search.next(loss);
        // Finer steps make it larger still.
        if (best.file && best.loss_db <= loss_db && loss > loss_db && candidate->size() >= best.file->size()) break;
        if (best.file && !better(loss, candidate->size(), best.loss_db, best.file->size(), loss_db)) continue;
        best = {std::move(candidate), loss};
      }
    }
    return best.opened();
  }

  /// Smaller, of those that lose no more than they may; else the one that loses less.
  static bool better(double loss, std::size_t bytes, double than_loss, std::size_t than_bytes, double most_loss) {
    const bool good = loss <= most_loss, than_good = than_loss <= most_loss;
    if (good != than_good) return good;
    return good ? bytes < than_bytes : loss < than_loss;
  }

  static std::shared_ptr<const CompactLightField> open(const std::shared_ptr<const std::string>& bytes) {
    auto opened =
        std::make_shared<CompactLightField>(decode_light_field(*bytes, "the compressed model", in_parallel), bytes);
    malloc_trim(0);
    return opened;
  }

  /// In dB of the PSNR of the pictures.
  double loss_of(const CompactLightField& compact) {
    if (!meter_) return psnr_db_ - target_.judge(compact);
    const double error =
        std::isfinite(target_.psnr_db) ? std::pow(10, -target_.psnr_db / 10) : meter_->predicted_error();
    return 10 * std::log10(1 + meter_->loss(compact) / std::max(error, 1e-12));
  }

  CompressionTarget target_;
  CanonicalMesh mesh_;
  double psnr_db_;  ///< as judged; NaN where nobody does
  CompactModel model_;
  std::size_t tries_ = 0;
  std::optional<LossMeter> meter_;  ///< where there is no judge
};

}  // namespace

std::unique_ptr<Compression> compress(const SurfaceLightFieldSnapshot& snapshot, CompressionTarget target) {
  if (const std::size_t cameras = snapshot.cameras().size(); cameras > kMostCameras)
    throw ConfigError("a small file holds at most " + std::to_string(kMostCameras) + " cameras, and this model has " +
                      std::to_string(cameras) + "; build it from fewer images, or save it without --bytes and --loss");
  if (snapshot.triangulated())
    throw ConfigError(
        "a small file holds views that kriging interpolates between, and this model was built with interpolation = "
        "\"delaunay\"");
  return std::make_unique<LightFieldCompression>(snapshot, std::move(target));
}

}  // namespace sheen
