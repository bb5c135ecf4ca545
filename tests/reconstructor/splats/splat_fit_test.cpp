// SPDX-License-Identifier: Apache-2.0
// Splats as a viewer of others reads and shows them: the file is parsed here, and its numbers are drawn here, splat by
// splat, by the equations of Kerbl et al. 2023.
#include "reconstructor/splats/splat_fit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <functional>
#include <map>
#include <sstream>

#include "common/base/files.h"
#include "common/image/color.h"
#include "reconstructor/render/ray_painter.h"
#include "reconstructor/splats/splat_file.h"
#include "reconstructor/splats/splat_painter.h"
#include "tests/support/temp_folder.h"
#include "tests/support/test_meshes.h"

namespace sheen {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr std::array<double, 16> kScale{0.28209479, 0.48860251, 0.48860251, 0.48860251, 1.09254843, 1.09254843,
                                        0.31539157, 1.09254843, 0.54627422, 0.59004359, 2.89061144, 0.45704579,
                                        0.37317633, 0.45704579, 1.44530572, 0.59004359};

/// The basis of the viewers, from their tables.
std::array<double, 16> viewer_basis(const Vector3d& d) {
  const double x = d.x(), y = d.y(), z = d.z();
  std::array<double, 16> basis{1,
                               -y,
                               z,
                               -x,
                               x * y,
                               -y * z,
                               2 * z * z - x * x - y * y,
                               -x * z,
                               x * x - y * y,
                               -y * (3 * x * x - y * y),
                               x * y * z,
                               -y * (4 * z * z - x * x - y * y),
                               z * (2 * z * z - 3 * x * x - 3 * y * y),
                               -x * (4 * z * z - x * x - y * y),
                               z * (x * x - y * y),
                               -x * (x * x - 3 * y * y)};
  for (std::size_t i = 0; i < basis.size(); ++i) basis[i] *= kScale[i];
  return basis;
}

/// The vertices of a binary PLY of floats.
std::vector<std::map<std::string, float>> vertices_of(const std::filesystem::path& file) {
  const std::string bytes = read_file(file);
  const std::size_t data = bytes.find("end_header\n") + 11;
  std::istringstream header(bytes.substr(0, data));
  std::vector<std::string> names;
  std::size_t count = 0;
  std::string line;
  EXPECT_TRUE(std::getline(header, line) && line == "ply");
  EXPECT_TRUE(std::getline(header, line) && line == "format binary_little_endian 1.0");
  while (std::getline(header, line)) {
    if (line.starts_with("element vertex ")) count = std::stoul(line.substr(15));
    if (line.starts_with("property float ")) names.push_back(line.substr(15));
  }
  EXPECT_EQ(bytes.size(), data + 4 * count * names.size());
  std::vector<std::map<std::string, float>> vertices(count);
  for (std::size_t i = 0; i < count * names.size(); ++i)
    std::memcpy(&vertices[i / names.size()][names[i % names.size()]], bytes.data() + data + 4 * i, 4);
  return vertices;
}

/// A splat as a viewer draws it.
struct Drawn {
  double depth, opacity;
  Eigen::Vector2d centre;
  Eigen::Matrix2d covariance;
  Vector3d colour;
};

Drawn drawn(const std::map<std::string, float>& vertex, const PosedCamera& from) {
  const auto three = [&](const char* a, const char* b, const char* c) {
    return Vector3d(vertex.at(a), vertex.at(b), vertex.at(c));
  };
  const Vector3d place = three("x", "y", "z"), in_camera = from.camera_from_object * place;
  const double depth = in_camera.z();
  const Eigen::Quaterniond turn(vertex.at("rot_0"), vertex.at("rot_1"), vertex.at("rot_2"), vertex.at("rot_3"));
  const Vector3d scale = three("scale_0", "scale_1", "scale_2").array().exp();
  const Eigen::Matrix3d axes = turn.toRotationMatrix() * scale.asDiagonal();
  Eigen::Matrix<double, 2, 3> derivative;
  derivative << from.camera.fx / depth, 0, -from.camera.fx * in_camera.x() / depth / depth, 0, from.camera.fy / depth,
      -from.camera.fy * in_camera.y() / depth / depth;
  const Eigen::Matrix<double, 2, 3> onto = derivative * from.camera_from_object.rotation.toRotationMatrix() * axes;
  const auto basis = viewer_basis((place - camera_centre(from.camera_from_object)).normalized());
  Vector3d colour;
  for (int c = 0; c < 3; ++c) {
    colour[c] = 0.5 + basis[0] * vertex.at("f_dc_" + std::to_string(c));
    for (int k = 1; k < 16; ++k)
      colour[c] += basis[std::size_t(k)] * vertex.at("f_rest_" + std::to_string(15 * c + k - 1));
  }
  return {depth, 1 / (1 + std::exp(-double(vertex.at("opacity")))), *from.camera.project(in_camera),
          onto * onto.transpose() + 0.3 * Eigen::Matrix2d::Identity(), colour.cwiseMax(0.0)};
}

/// Encoded; over black.
ImageF drawn_picture(const std::vector<std::map<std::string, float>>& vertices, const PosedCamera& from) {
  std::vector<Drawn> splats;
  for (const auto& vertex : vertices) splats.push_back(drawn(vertex, from));
  std::sort(splats.begin(), splats.end(), [](const Drawn& a, const Drawn& b) { return a.depth > b.depth; });
  ImageF picture(from.camera.width, from.camera.height, 3);
  for (const Drawn& splat : splats) {  // from the back
    const Eigen::Matrix2d inverse = splat.covariance.inverse();
    for (int y = 0; y < picture.height(); ++y)
      for (int x = 0; x < picture.width(); ++x) {
        const Eigen::Vector2d off = Eigen::Vector2d(x, y) - splat.centre;
        const double alpha = std::min(0.99, splat.opacity * std::exp(-0.5 * off.dot(inverse * off)));
        if (alpha < 1.0 / 255) continue;
        for (int c = 0; c < 3; ++c)
          picture.at(x, y, c) = float(alpha * splat.colour[c] + (1 - alpha) * picture.at(x, y, c));
      }
  }
  return picture;
}

/// A surface whose encoded colour is a function of the place and of the direction from the eye to it.
class Glow : public Appearance {
 public:
  using Colour = std::function<Vector3f(const Vector3f& place, const Vector3f& direction)>;
  Glow(Mesh mesh, Colour colour) : mesh_(std::move(mesh)), colour_(std::move(colour)) {}

  const Mesh& mesh() const override { return mesh_; }
  std::unique_ptr<ViewShader> shader_for(const ViewQuery& query) const override {
    return std::make_unique<Shader>(*this, query.eye.cast<float>());
  }
  /// As if it were the same from everywhere.
  std::unique_ptr<ViewShader> mean_look() const { return std::make_unique<Shader>(*this, Vector3f(0, 0, 100)); }

 private:
  class Shader : public ViewShader {
   public:
    Shader(const Glow& glow, Vector3f eye) : glow_(glow), eye_(std::move(eye)) {}
    SurfaceSample shade(std::uint32_t t, float u, float v) const override {
      const Mesh& mesh = glow_.mesh_;
      const Vector3f place = (1 - u - v) * mesh.corner(t, 0) + u * mesh.corner(t, 1) + v * mesh.corner(t, 2);
      return {glow_.colour_(place, (place - eye_).normalized()).unaryExpr(&srgb_decode), SampleState::kMeasured};
    }
    SurfaceQuality quality(std::uint32_t) const override { return {}; }

   private:
    const Glow& glow_;
    Vector3f eye_;
  };

  Mesh mesh_;
  Colour colour_;
};

FittedSplats fitted_to(const Glow& glow, std::size_t count) {
  return fit_splats({glow, *glow.mean_look(), {}}, count, kMostSplatDegree);
}

/// All round a ball of 0.1 m.
PosedCamera camera_from(const Vector3d& direction) {
  const Camera camera{.width = 90, .height = 80, .fx = 110, .fy = 110, .cx = 44, .cy = 39};
  return {camera, look_at(0.3 * direction.normalized(), Vector3d::Zero(), Vector3d(0.1, 0.2, 1))};
}

/// PSNR of the file's picture against the model's, on the object; no farther in than its outline's pixels.
double psnr_of_file(const Glow& glow, const Splats& splats, const PosedCamera& from) {
  const TempFolder temp;
  write_splats(temp.path() / "splats.ply", splats, Vector3d::Zero());
  const ImageF shown = drawn_picture(vertices_of(temp.path() / "splats.ply"), from);
  const PaintedView truth = RayPainter(glow.mesh()).paint(glow, from.camera, from.camera_from_object);
  double squares = 0, values = 0;
  for (std::size_t i = 0; i < truth.beauty.size(); ++i) {
    if (truth.coverage.data()[i / 3] == 0) continue;
    squares += std::pow(shown.data()[i] - srgb_encode(truth.beauty.data()[i]), 2);
    values += 1;
  }
  EXPECT_GT(values, 3000) << "the object is in the picture";
  return -10 * std::log10(squares / values);
}

TEST(SplatFit, ADullBallHasOneColour) {
  const Vector3f colour(0.8f, 0.5f, 0.2f);
  const Glow glow(sphere_mesh(0.1f, 3), [&](const Vector3f&, const Vector3f&) { return colour; });
  const FittedSplats fitted = fitted_to(glow, 300);
  ASSERT_GT(fitted.splats.shapes.size(), 290u);
  for (std::size_t i = 0; i < fitted.splats.shapes.size(); ++i)
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(fitted.splats.channel(i, c)[0], (colour[c] - 0.5) / kScale[0], 1e-3);
      EXPECT_LT(fitted.splats.channel(i, c).tail(15).cwiseAbs().maxCoeff(), 1e-3);
    }
}

TEST(SplatFit, HarmonicsOfAllDegreesComeBack) {
  const auto colour = [](const Vector3f&, const Vector3f& direction) {
    const auto basis = viewer_basis(direction.cast<double>());
    return Vector3f(0.5 + 0.2 * basis[1] + 0.1 * basis[12], 0.4 + 0.1 * basis[4] + 0.1 * basis[3],
                    0.6 + 0.1 * basis[9] - 0.1 * basis[7]);
  };
  const Glow glow(sphere_mesh(0.1f, 3), colour);
  const FittedSplats fitted = fitted_to(glow, 400);
  EXPECT_GT(fitted.psnr_db, 40);
  for (const Vector3d& direction : {Vector3d(1, 0.3, 0.2), Vector3d(-0.4, -1, 0.5), Vector3d(0.2, 0.3, -1)})
    EXPECT_GT(psnr_of_file(glow, fitted.splats, camera_from(direction)), 34) << direction.transpose();
}

TEST(SplatFit, ATextureThatShinesIsShownFromTheFile) {
  const auto colour = [](const Vector3f& place, const Vector3f& direction) {
    const float shine =
        std::pow(std::max(0.0f, -direction.dot((place.normalized() + Vector3f(0, 0, 0.3f)).normalized())), 4.0f);
    return Vector3f(0.3f + 0.15f * std::sin(40 * place.x()) + 0.3f * shine, 0.3f + 0.3f * shine,
                    0.3f + 0.15f * std::sin(50 * place.z()) + 0.3f * shine);
  };
  const Glow glow(sphere_mesh(0.1f, 3), colour);
  const FittedSplats fitted = fitted_to(glow, 1500);
  for (const Vector3d& direction : {Vector3d(1, 0.3, 0.2), Vector3d(-0.4, -1, 0.5)})
    EXPECT_GT(psnr_of_file(glow, fitted.splats, camera_from(direction)), 32) << direction.transpose();
}

TEST(SplatFit, AViewersPictureIsOurs) {
  const Glow glow(sphere_mesh(0.1f, 2), [](const Vector3f& place, const Vector3f& direction) {
    return Vector3f(0.5f + 3 * place.x(), 0.5f + 0.3f * direction.y(), 0.5f);
  });
  const FittedSplats fitted = fitted_to(glow, 200);
  const TempFolder temp;
  write_splats(temp.path() / "splats.ply", fitted.splats, Vector3d::Zero());
  const PosedCamera from = camera_from({1, -0.4, 0.3});
  const ImageF ours = paint_splats(fitted.splats, from);
  const ImageF theirs = drawn_picture(vertices_of(temp.path() / "splats.ply"), from);
  float most = 0;
  for (std::size_t i = 0; i < theirs.size(); ++i)
    most = std::max(most, std::abs(theirs.data()[i] - ours.data()[i / 3 * 4 + i % 3]));
  EXPECT_LT(most, 0.02f) << "what is left out is less than 1/255 each";
}

TEST(SplatFile, StandsWhereTheMeshsFileStands) {
  Splats splats{.degree = 1, .shapes = {}, .colours = Eigen::MatrixXf::Zero(12, 1)};
  splats.shapes.push_back({{1, 2, 3}, Eigen::Quaternionf(0.5f, 0.5f, 0.5f, 0.5f), {0.001f, 0.1f, 1}, 0.75f});
  for (int i = 0; i < 12; ++i) splats.colours(i, 0) = float(i);
  const TempFolder temp;
  const auto file = temp.path() / "one.ply";
  write_splats(file, splats, {1000, 0, -1});
  const auto vertices = vertices_of(file);
  ASSERT_EQ(vertices.size(), 1u);
  EXPECT_EQ(4 * vertices[0].size(), splat_bytes(1));
  const std::map<std::string, float> expected{{"x", 1001},
                                              {"y", 2},
                                              {"z", 2},
                                              {"f_dc_0", 0},
                                              {"f_dc_1", 4},
                                              {"f_dc_2", 8},
                                              {"f_rest_0", 1},
                                              {"f_rest_2", 3},
                                              {"f_rest_3", 5},
                                              {"f_rest_8", 11},
                                              {"nx", 0},
                                              {"ny", 1},
                                              {"nz", 0},
                                              {"rot_0", 0.5f},
                                              {"rot_3", 0.5f},
                                              {"scale_2", 0},
                                              {"scale_1", std::log(0.1f)},
                                              {"opacity", std::log(3.0f)}};
  for (const auto& [name, value] : expected) EXPECT_NEAR(vertices[0].at(name), value, 1e-6) << name;
}

}  // namespace
}  // namespace sheen
