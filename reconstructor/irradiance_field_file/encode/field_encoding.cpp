// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/irradiance_field_file/encode/field_encoding.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "common/parallel/for_each.h"
#include "reconstructor/coding/camera_json.h"
#include "reconstructor/irradiance_field_file/field_coder.h"
#include "reconstructor/irradiance_field_file/field_format.h"

namespace sheen {
namespace {

using OrderedJson = nlohmann::ordered_json;

// Smaller values than this part of a step less than one are rounded to zero: it costs less than it keeps.
constexpr float kRounding = 0.4f;
// The basis takes this part of the error that the maps have.
constexpr double kBasisPart = 0.05;
constexpr std::int32_t kMostCoefficient = 1 << 22;

OrderedJson describe(const LitScene& scene, const QuantisedField& field) {
  return {{"step", field.step},
          {"camera", cameras_to_json({scene.camera})},
          {"light_kind", static_cast<int>(scene.kind)},
          {"lights", std::vector<double>(scene.lights.data(), scene.lights.data() + scene.lights.size())},
          {"kernel",
           {{"shape", static_cast<int>(scene.kernel.shape)},
            {"drift_degree", scene.kernel.drift_degree},
            {"depth", scene.kernel.depth}}},
          {"error", scene.error},
          {"terms", {field.components[0].terms(), field.components[1].terms(), field.components[2].terms()}}};
}

}  // namespace

QuantisedField quantise(const FieldTerms& field, int lights, float step) {
  QuantisedField quantised{.size = field.size, .lights = lights, .step = step};
  for (std::size_t c = 0; c < field.components.size(); ++c) {
    const FieldTerms::Component& from = field.components[c];
    QuantisedField::Component& to = quantised.components[c];
    const auto rows = static_cast<std::size_t>(from.coefs.rows());
    const auto rounded = [step](float value) {
      const float steps = value / step;
      const auto size = static_cast<std::int32_t>(std::min(std::abs(steps) + kRounding, float{kMostCoefficient}));
      return steps < 0 ? -size : size;
    };
    Eigen::Index terms = from.coefs.cols();
    while (terms > 0 && rounded(from.coefs.col(terms - 1).cwiseAbs().maxCoeff()) == 0) --terms;
    to.coefs.reserve(static_cast<std::size_t>(terms) * rows);
    for (Eigen::Index t = 0; t < terms; ++t) {
      for (const float value : from.coefs.col(t)) to.coefs.push_back(rounded(value));
      // An error d of a basis column is one of d * rms in the images; n of them add up in each.
      const double rms = from.coefs.col(t).norm() / std::sqrt(static_cast<double>(rows)),
                   unit = std::sqrt(kBasisPart / lights) * step / std::max(rms, 1e-9);
      const int bits = std::clamp(static_cast<int>(std::ceil(-std::log2(unit))), 0, field_coder::kMostBits);
      to.bits.push_back(static_cast<std::uint8_t>(bits));
      for (const float value : from.basis.col(t))
        to.basis.push_back(static_cast<std::int32_t>(std::lround(std::ldexp(value, bits))));
    }
  }
  return quantised;
}

std::string encode_component(const QuantisedField& field, std::size_t component) {
  QuantisedField::Component copy = field.components[component];
  BitModel bits(field_coder::kContexts);
  ContextEncoder encoder(bits);
  field_coder::code_component(encoder, field, copy);
  return encoder.finish();
}

std::string encode_field(const LitScene& scene, const QuantisedField& field) {
  std::string out = start_of_file(kFieldFileFormat, {});
  append_chunk(out, "DESC", packed(describe(scene, field).dump()));
  std::array<std::string, kMapChunks.size()> maps;
  in_parallel(maps.size(), [&](std::size_t c) { maps[c] = encode_component(field, c); });
  for (std::size_t c = 0; c < maps.size(); ++c) append_chunk(out, kMapChunks[c], maps[c]);
  return out;
}

}  // namespace sheen
