// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/exchange/polynomial_texture.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/image/image_io.h"

namespace sheen {
namespace {

constexpr int kTerms = PolynomialTexture::kTerms, kQuality = 98;
constexpr double kLeastEigenvalue = 1e-6;  // of the lights' products, over the greatest

/// Coefficients in 8 bits: value = scale * (byte - bias). One for the three colours, so that grey stays grey.
struct Quantisation {
  double scale = 1;
  int bias = 0;

  explicit Quantisation(const ImageF& plane, double unit) {
    const auto [least, most] = std::minmax_element(plane.data(), plane.data() + plane.size());
    const double low = std::min(0.0, unit * static_cast<double>(*least)),
                 high = std::max(0.0, unit * static_cast<double>(*most));
    scale = std::max(high - low, 1e-6) / 254;  // one level for the rounding of the bias
    bias = static_cast<int>(std::ceil(-low / scale));
  }
  std::uint8_t byte(double value) const {
    return static_cast<std::uint8_t>(std::clamp<long>(std::lround(value / scale) + bias, 0, 255));
  }
};

constexpr const char* kPage = R"html(<!doctype html>
<meta charset="utf-8">
<title>Sheen</title>
<style>
html, body, #view { margin: 0; height: 100%; background: #222 }
#view { position: relative }
#view canvas { display: block; width: 100%; height: 100% }
.openlime-overlay { position: absolute; inset: 0 }
</style>
<div id="view"></div>
<script src="openlime.umd.js"></script>
<script>
if (typeof OpenLIME === 'undefined') {
  document.body.textContent = 'Put openlime.umd.js of OpenLIME (npm: openlime) beside this page.';
} else {
  const viewer = new OpenLIME.Viewer('#view');
  const layer = new OpenLIME.Layer({ type: 'rti', url: 'info.json', layout: 'image' });
  viewer.addLayer('object', layer);
  const drag = new OpenLIME.Controller2D((x, y) => layer.setLight([x, y], 0), { active: true, control: 'light', layer });
  viewer.pointerManager.onEvent(drag);
}
</script>
)html";

}  // namespace

std::array<double, kTerms> PolynomialTexture::terms(const Eigen::Vector3d& light) {
  const Eigen::Vector3d l = light.normalized();
  return {1, l.x(), l.y(), l.x() * l.x(), l.x() * l.y(), l.y() * l.y()};
}

ImageF PolynomialTexture::picture(const Eigen::Vector3d& light) const {
  const std::array<double, kTerms> weights = terms(light);
  ImageF picture(planes[0].width(), planes[0].height(), 3);
  for (std::size_t t = 0; t < planes.size(); ++t)
    for (std::size_t i = 0; i < picture.size(); ++i)
      picture.data()[i] += static_cast<float>(weights[t]) * planes[t].data()[i];
  return picture;
}

PolynomialFit::PolynomialFit(int width, int height) {
  gram_.setZero();
  for (ImageF& sum : sums_) sum = ImageF(width, height, 3);
}

void PolynomialFit::add(const Eigen::Vector3d& light, const ImageF& encoded) {
  const std::array<double, kTerms> weights = PolynomialTexture::terms(light);
  const Eigen::Map<const Eigen::Matrix<double, kTerms, 1>> row(weights.data());
  gram_ += row * row.transpose();
  for (std::size_t t = 0; t < sums_.size(); ++t)
    for (std::size_t i = 0; i < encoded.size(); ++i)
      sums_[t].data()[i] += static_cast<float>(weights[t]) * encoded.data()[i];
}

PolynomialTexture PolynomialFit::texture() const {
  const Eigen::SelfAdjointEigenSolver<decltype(gram_)> eigen(gram_);
  if (!(eigen.eigenvalues()[0] > kLeastEigenvalue * eigen.eigenvalues()[kTerms - 1]))
    throw ConfigError("its lights are too few, or all on a curve, for a polynomial of six terms");
  const auto inverse = gram_.inverse().eval();
  PolynomialTexture texture;
  for (int t = 0; t < kTerms; ++t) {
    ImageF& plane = texture.planes[static_cast<std::size_t>(t)];
    plane = ImageF(sums_[0].width(), sums_[0].height(), 3);
    for (int s = 0; s < kTerms; ++s)
      for (std::size_t i = 0; i < plane.size(); ++i)
        plane.data()[i] += static_cast<float>(inverse(t, s)) * sums_[static_cast<std::size_t>(s)].data()[i];
  }
  return texture;
}

void write_ptm(const std::filesystem::path& file, const PolynomialTexture& texture) {
  constexpr std::array<std::size_t, kTerms> kOrder{3, 5, 4, 1, 2, 0};  // x^2, y^2, xy, x, y, 1
  constexpr double kWhite = 255;
  const int w = texture.planes[0].width(), h = texture.planes[0].height();
  std::string bytes = "PTM_1.2\nPTM_FORMAT_RGB\n" + std::to_string(w) + "\n" + std::to_string(h) + "\n";
  std::vector<Quantisation> levels;
  for (const std::size_t term : kOrder) levels.emplace_back(texture.planes[term], kWhite);
  const auto line = [&](const auto& text_of) {
    std::string text;
    for (const Quantisation& level : levels) text += (text.empty() ? "" : " ") + text_of(level);
    bytes += text + "\n";
  };
  line([](const Quantisation& level) { return std::to_string(level.scale); });
  for (Quantisation& level : levels) level.scale = std::stod(std::to_string(level.scale));  // as readers have it
  line([](const Quantisation& level) { return std::to_string(level.bias); });
  for (int c = 0; c < 3; ++c)
    for (int y = h - 1; y >= 0; --y)  // the lowest row comes first
      for (int x = 0; x < w; ++x)
        for (std::size_t t = 0; t < kOrder.size(); ++t)
          bytes +=
              static_cast<char>(levels[t].byte(kWhite * static_cast<double>(texture.planes[kOrder[t]].at(x, y, c))));
  write_file(file, bytes);
}

void write_relight(const std::filesystem::path& folder, const PolynomialTexture& texture) {
  make_folder(folder);
  const int w = texture.planes[0].width(), h = texture.planes[0].height();
  nlohmann::json scales = nlohmann::json::array(), biases = nlohmann::json::array();
  for (std::size_t t = 0; t < texture.planes.size(); ++t) {
    const ImageF& plane = texture.planes[t];
    const Quantisation level(plane, 1);
    ImageU8 bytes(w, h, 3);
    for (std::size_t i = 0; i < plane.size(); ++i) bytes.data()[i] = level.byte(static_cast<double>(plane.data()[i]));
    const std::vector<std::uint8_t> jpeg = encode_jpeg(bytes, kQuality);
    write_file(folder / ("plane_" + std::to_string(t) + ".jpg"), std::string(jpeg.begin(), jpeg.end()));
    for (int c = 0; c < 3; ++c) {  // textures are 0..1
      scales.push_back(255 * level.scale);
      biases.push_back(level.bias / 255.0);
    }
  }
  const nlohmann::json info{{"width", w},          {"height", h},
                            {"format", "jpg"},     {"type", "ptm"},
                            {"colorspace", "rgb"}, {"nplanes", 3 * kTerms},
                            {"quality", kQuality}, {"materials", {{{"scale", scales}, {"bias", biases}}}}};
  write_file(folder / "index.html", kPage);
  write_file(folder / "info.json", info.dump(1) + "\n");
}

}  // namespace sheen
