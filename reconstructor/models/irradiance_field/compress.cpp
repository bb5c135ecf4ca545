// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/irradiance_field/compress.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "common/base/errors.h"
#include "reconstructor/coding/step_search.h"
#include "reconstructor/irradiance_field_file/encode/field_encoding.h"

namespace sheen {
namespace {

constexpr double kFirstStep = 24, kCoarsestStep = 5000;

class FieldCompression : public Compression {
 public:
  FieldCompression(const IrradianceFieldSnapshot& exact, CompressionTarget target)
      : target_(std::move(target)),
        mesh_(exact.shared_mesh()),
        scene_(exact.scene()),
        lights_(exact.field().lights),
        version_(exact.version()),
        psnr_db_(target_.judge ? target_.judge(exact) : std::numeric_limits<double>::quiet_NaN()),
        terms_(dequantise(exact.field())) {}

  CompressedModel run() override {
    const QuantisedField field = target_.bytes ? within_bytes(*target_.bytes) : within_loss(target_.loss_db);
    auto small = open(field);
    const double loss = target_.judge ? psnr_db_ - target_.judge(*small) : predicted_loss(field);
    return {std::move(small), loss, encode_field(scene_, field).size()};
  }

 private:
  QuantisedField at(double step) const { return quantise(terms_, lights_, static_cast<float>(step)); }
  std::shared_ptr<const IrradianceFieldSnapshot> open(const QuantisedField& field) const {
    return std::make_shared<IrradianceFieldSnapshot>(mesh_, scene_, field, version_, true);
  }

  QuantisedField within_bytes(double bytes) const {
    StepSearch search(bytes, -0.9, kFirstStep, kFinestStep, kCoarsestStep);
    std::optional<QuantisedField> best;
    std::size_t least = SIZE_MAX, best_size = 0;
    for (bool more = true; more;) {
      const double step = search.step();
      QuantisedField field = at(step);
      const std::size_t size = encode_field(scene_, field).size() + kNotesReserve;
      more = search.next(static_cast<double>(size));
      least = std::min(least, size);
      const bool fits = static_cast<double>(size) <= bytes;
      if (fits && size > best_size) {
        best_size = size;
        best = std::move(field);
      }
    }
    if (!best)
      throw ConfigError("the model does not fit into " + std::to_string(static_cast<std::size_t>(bytes)) +
                        " bytes: the least that was reached is " + std::to_string(least));
    return std::move(*best);
  }

  QuantisedField within_loss(double loss_db) {
    StepSearch search(loss_db, 1.2, kFirstStep, kFinestStep, kCoarsestStep);
    std::optional<QuantisedField> best;
    double best_step = 0, best_loss = INFINITY;
    for (bool more = true; more;) {
      const double step = search.step();
      QuantisedField field = at(step);
      const double loss = target_.judge ? psnr_db_ - target_.judge(*open(field)) : predicted_loss(field);
      more = search.next(loss);
      const bool better = loss <= loss_db ? !(best_loss <= loss_db) || step > best_step : loss < best_loss;
      if (!better) continue;
      best_step = step;
      best_loss = loss;
      best = std::move(field);
    }
    return std::move(*best);
  }

  /// In dB: what coding adds to the images, beside the error that interpolating between them has anyway.
  double predicted_loss(const QuantisedField& field) const {
    const FieldTerms coded = dequantise(field);
    double added = 0;
    const auto rows = static_cast<double>(terms_.components[0].coefs.rows());
    for (std::size_t c = 0; c < terms_.components.size(); ++c) {
      const Eigen::MatrixXf &from = terms_.components[c].coefs, &to = coded.components[c].coefs;
      for (Eigen::Index t = 0; t < from.cols(); ++t)
        added += t < to.cols() ? (from.col(t) - to.col(t)).squaredNorm() : from.col(t).squaredNorm();
    }
    added /= 3 * rows * lights_ * 255.0 * 255.0;
    const double error =
        std::isfinite(target_.psnr_db) ? std::pow(10, -target_.psnr_db / 10) : scene_.error * scene_.error;
    return 10 * std::log10(1 + added / std::max(error, 1e-9));
  }

  // What the notes take (source, settings, images) is not known yet.
  static constexpr std::size_t kNotesReserve = 2000;

  CompressionTarget target_;
  std::shared_ptr<const Mesh> mesh_;
  LitScene scene_;
  int lights_;
  std::uint64_t version_;
  double psnr_db_;  ///< as judged; NaN where nobody does
  FieldTerms terms_;
};

}  // namespace

std::unique_ptr<Compression> compress_field(const IrradianceFieldSnapshot& exact, CompressionTarget target) {
  if (exact.empty()) throw ConfigError("the model holds no image: there is nothing to make small");
  return std::make_unique<FieldCompression>(exact, std::move(target));
}

}  // namespace sheen
