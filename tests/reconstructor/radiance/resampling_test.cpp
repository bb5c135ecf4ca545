// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/radiance/resampling.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "common/image/color.h"
#include "tests/support/test_meshes.h"

namespace sheen {
namespace {

constexpr float kSteps[] = {0.01f, 1, 1.6f, 1.61f, 3.2f, 3.3f, 6.4f, 12.8f, 1000};

template <typename F>  // f(x, y, channel)
ImageF image_of(int width, int height, F&& f) {
  ImageF image(width, height, 3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 3; ++c) image.at(x, y, c) = static_cast<float>(f(x, y, c));
  return image;
}

ImageF noise(int width, int height) {
  std::mt19937 engine(7);
  std::uniform_real_distribution<float> uniform(0.1f, 1);
  return image_of(width, height, [&](int, int, int) { return uniform(engine); });
}

TEST(Resampling, AConstantStaysConstantAtAllLevelsAndUpToTheBorder) {
  for (const auto& [w, h] :
       {std::pair(100, 60), std::pair(37, 41), std::pair(9, 9), std::pair(3, 2), std::pair(1, 1)}) {
    const RadianceImage image(image_of(w, h, [](int, int, int c) { return 0.25f * (c + 1); }));
    for (const float step : kSteps)
      for (const Eigen::Vector2f& p :
           {Eigen::Vector2f(0, 0), Eigen::Vector2f(w - 1, h - 1), Eigen::Vector2f(0.37f * (w - 1), 0.81f * (h - 1))})
        EXPECT_LT((image.sample(p, step) - Eigen::Vector3f(0.25f, 0.5f, 0.75f)).cwiseAbs().maxCoeff(), 1e-6f)
            << w << "x" << h << " step " << step;
  }
}

TEST(Resampling, FullResolutionGivesBackThePixels) {
  const ImageF pixels = noise(40, 30);
  const RadianceImage image(pixels);
  for (int y = 0; y < 30; ++y)
    for (int x = 0; x < 40; ++x)
      EXPECT_LT((image.sample(Eigen::Vector2f(x, y), 1) - Eigen::Map<const Eigen::Vector3f>(pixels.pixel(x, y)))
                    .cwiseAbs()
                    .maxCoeff(),
                5e-6f);
}

// Cubic convolution with parameter a keeps constants; on f(x) = x its error is (1 + 2 a) t (1 - t) (2 t - 1) at the
// fraction t between two pixels (no error for a = -1/2 alone), which is below 0.02 of a pixel for a = -0.6.
TEST(Resampling, ARampIsReproducedAsTheKernelsMomentsSay) {
  const RadianceImage image(image_of(64, 64, [](int x, int y, int c) { return c == 0 ? x : c == 1 ? y : x + 2 * y; }));
  const auto error = [](double t) { return (1 - 2 * 0.6) * t * (1 - t) * (2 * t - 1); };
  for (int i = 0; i <= 20; ++i)
    for (int j = 0; j <= 20; ++j) {
      const double tx = i / 20.0, ty = j / 20.0, x = 30 + tx, y = 17 + ty;
      const Eigen::Vector3f value = image.sample(Eigen::Vector2f(x, y), 1);
      EXPECT_NEAR(value[0], x + error(tx), 1e-4);
      EXPECT_NEAR(value[1], y + error(ty), 1e-4);
      EXPECT_NEAR(value[2], x + error(tx) + 2 * (y + error(ty)), 3e-4);
      EXPECT_LT(std::abs(value[0] - x), 0.02);
    }
}

TEST(Resampling, TheCoarserLevelsReproduceARampExactly) {
  const RadianceImage image(image_of(128, 128, [](int x, int y, int c) { return c == 0 ? x : c == 1 ? y : 1 + x; }));
  for (const float step : {1.7f, 3.2f, 5.0f, 6.4f, 12.0f})
    for (int i = 0; i <= 10; ++i) {
      const float x = 50 + 0.37f * i, y = 60.5f - 0.61f * i;
      const Eigen::Vector3f value = image.sample(Eigen::Vector2f(x, y), step);
      EXPECT_LT((value - Eigen::Vector3f(x, y, 1 + x)).cwiseAbs().maxCoeff(), 2e-4f) << step;
    }
}

TEST(Resampling, ACoarseSampleIsTheMeanOfItsBlock) {
  const ImageF pixels = noise(64, 48);
  const RadianceImage image(pixels);
  for (int level = 1; level <= 3; ++level) {
    const int block = 1 << level;
    const float step = 1.6f * block;
    for (int by = 0; by < 48 / block; ++by)
      for (int bx = 0; bx < 64 / block; ++bx) {
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        for (int y = 0; y < block; ++y)
          for (int x = 0; x < block; ++x)
            sum += Eigen::Map<const Eigen::Vector3f>(pixels.pixel(bx * block + x, by * block + y)).cast<double>();
        const Eigen::Vector2f centre((bx + 0.5f) * block - 0.5f, (by + 0.5f) * block - 0.5f);
        EXPECT_LT((image.sample(centre, step).cast<double>() - sum / (block * block)).cwiseAbs().maxCoeff(), 1e-5);
      }
  }
}

TEST(Resampling, AMapFinerThanTheImageReadsTheFullImage) {
  const RadianceImage image(
      image_of(64, 64, [](int x, int y, int) { return (x + y) % 2; }));  // nothing survives a halving
  for (const float step : {0.01f, 0.5f, 1.0f, 1.6f}) {
    EXPECT_NEAR(image.sample({20, 21}, step).x(), 1, 5e-6) << step;
    EXPECT_NEAR(image.sample({20, 20}, step).x(), 0, 5e-6) << step;
  }
  for (const float step : {1.61f, 3.2f, 6.0f, 100.0f}) EXPECT_EQ(image.sample({20, 20}, step).x(), 0.5f) << step;
}

TEST(Resampling, LightIsNeverNegative) {
  const RadianceImage image(image_of(16, 16, [](int x, int, int) { return x < 8 ? 0 : 100; }));
  float lowest = 1;
  for (int i = 0; i <= 150; ++i) lowest = std::min(lowest, image.sample(Eigen::Vector2f(0.1f * i, 8), 1).minCoeff());
  EXPECT_EQ(lowest, 0) << "the kernel's overshoot is cut off";
}

/// A capture of float pixels, and a view of all of it whose samples stand `step` pixels apart.
Capture capture_of(const ImageF& pixels) {
  Capture capture;
  capture.image = {.format = PixelFormat::kRGB32f, .width = pixels.width(), .height = pixels.height()};
  capture.image.stride = 12 * static_cast<std::size_t>(pixels.width());
  capture.image.bytes.resize(4 * pixels.size());
  std::memcpy(capture.image.bytes.data(), pixels.data(), 4 * pixels.size());
  return capture;
}

/// No pixel touches an edge.
SurfaceView view_of(const ImageF& pixels, const PixelBox& box, float step) {
  SurfaceView view;
  view.from_edge = ImageU8(pixels.width(), pixels.height(), 1, 2);
  view.box = box;
  view.step_px = {step};
  return view;
}

TEST(Resampling, PixelsThatAreNoNumbersAreMarkedAndReadAsZero) {
  ImageF pixels = noise(20, 10);
  EXPECT_TRUE(usable_pixels(capture_of(pixels)).empty());
  pixels.at(3, 4, 1) = std::numeric_limits<float>::quiet_NaN();
  pixels.at(19, 9, 2) = std::numeric_limits<float>::infinity();
  pixels.at(0, 0, 0) = -std::numeric_limits<float>::infinity();
  Capture capture = capture_of(pixels);
  const ImageU8 usable = usable_pixels(capture);
  RadianceImage image;
  image.load(capture, view_of(pixels, {0, 0, 20, 10}, 1000));
  ASSERT_EQ(usable.width(), 20);
  ASSERT_EQ(usable.height(), 10);
  for (int y = 0; y < 10; ++y)
    for (int x = 0; x < 20; ++x) {
      const bool broken = (x == 3 && y == 4) || (x == 19 && y == 9) || (x == 0 && y == 0);
      EXPECT_EQ(usable.at(x, y) != 0, !broken);
      for (const float step : kSteps) EXPECT_TRUE(image.sample(Eigen::Vector2f(x + 0.3f, y - 0.2f), step).allFinite());
    }
  EXPECT_LT(image.sample({3, 4}, 1).norm(), 1e-5f);

  capture.mask = ImageU8(20, 10, 1, 255);
  capture.mask.at(7, 7) = 0;
  const ImageU8 both = usable_pixels(capture);
  EXPECT_EQ(both.at(7, 7), 0) << "the capture's own mask stays";
  EXPECT_EQ(both.at(3, 4), 0);
  EXPECT_NE(both.at(8, 7), 0);
}

TEST(Resampling, APartOfTheImageReadsAsTheWholeDoes) {
  const ImageF pixels = noise(120, 90);
  const RadianceImage whole(pixels);
  const Capture capture = capture_of(pixels);
  RadianceImage part;
  for (const PixelBox& box : {PixelBox{33, 21, 57, 60}, PixelBox{0, 0, 9, 90}, PixelBox{100, 80, 120, 90}})
    for (const float step : {1.0f, 2.0f, 5.0f, 12.0f})
      for (const Sampling sampling : {Sampling::kCubic, Sampling::kLinear}) {
        part.load(capture, view_of(pixels, box, step));
        for (float y = static_cast<float>(box.y0); y <= box.y1 - 1; y += 0.7f)
          for (float x = static_cast<float>(box.x0); x <= box.x1 - 1; x += 0.7f)
            EXPECT_LT(
                (part.sample({x, y}, step, sampling) - whole.sample({x, y}, step, sampling)).cwiseAbs().maxCoeff(),
                2e-6f)
                << x << ' ' << y << ' ' << step;
      }
}

TEST(Resampling, BesideASilhouetteASampleHasTheObjectsColour) {
  // A disc of one colour on black and on a glaring ground, with mixed pixels at its rim and some that are no numbers.
  const Eigen::Vector3f colour(0.3f, 0.5f, 0.7f);
  for (const float ground : {0.0f, 5.0f}) {
    SurfaceView view = view_of(ImageF(64, 64, 1), {10, 10, 54, 54}, 0);
    const auto fraction = [](int x, int y) { return std::clamp(20.5f - std::hypot(x - 31.3f, y - 32.1f), 0.0f, 1.0f); };
    ImageF pixels = image_of(
        64, 64, [&](int x, int y, int c) { return fraction(x, y) * colour[c] + (1 - fraction(x, y)) * ground; });
    for (int y = 0; y < 64; ++y)
      for (int x = 0; x < 64; ++x) {
        float least = 1;
        for (int j = -1; j <= 1; ++j)
          for (int i = -1; i <= 1; ++i) least = std::min(least, fraction(x + i, y + j));
        view.from_edge.at(x, y) = fraction(x, y) < 1 ? 0 : least < 1 ? 1 : 2;
      }
    for (int x = 0; x < 64; ++x)
      if (fraction(x, 40) < 1) pixels.at(x, 40, 1) = std::numeric_limits<float>::quiet_NaN();
    for (const float step : {1.0f, 3.0f}) {  // the kernel itself, and the level of half the size
      view.step_px = {step};
      for (const Sampling sampling : {Sampling::kCubic, Sampling::kLinear}) {
        RadianceImage image;
        image.load(capture_of(pixels), view);
        std::size_t beside = 0;
        for (float y = 8; y < 56; y += 0.23f)
          for (float x = 8; x < 56; x += 0.23f) {
            const int i = static_cast<int>(x + 0.5f), j = static_cast<int>(y + 0.5f);
            if (view.from_edge.at(i, j) == 0) continue;  // as visibility decides
            beside +=
                fraction(i - 1, j) < 1 || fraction(i + 1, j) < 1 || fraction(i, j - 1) < 1 || fraction(i, j + 1) < 1;
            ASSERT_LT((image.sample({x, y}, step, sampling) - colour).cwiseAbs().maxCoeff(), 1e-5f) << x << ' ' << y;
          }
        EXPECT_GT(beside, 1000u);
      }
    }
  }
}

/// Two squares of one colour each over each other, on a glaring ground, seen through a pinhole from the side: the mean
/// of 7 x 7 rays per pixel, met in closed form.
struct TwoSquares {
  static constexpr float kFloor = 0.4f, kUpper = 0.12f;  // half their sides, at z = 0 and 0.5
  Camera camera{.width = 240, .height = 180, .fx = 300, .fy = 300, .cx = 119.5, .cy = 89.5};
  Rigid3 camera_from_object = look_at({0.6, -0.5, 2}, {0.05, 0, 0}, {0.2, 1, 0});
  Mesh mesh = joined(square_mesh(kFloor, 0, 8), square_mesh(kUpper, 0.5f, 3));

  Eigen::Vector3f colour(const Eigen::Vector3d& eye, const Eigen::Vector3d& ray) const {
    const auto meets = [&](double z, double half) {
      const Eigen::Vector3d p = eye + ray * ((z - eye.z()) / ray.z());
      return std::max(std::abs(p.x()), std::abs(p.y())) < half;
    };
    return meets(0.5, kUpper) ? upper_colour : meets(0, kFloor) ? floor_colour : Eigen::Vector3f::Constant(3);
  }
  ImageF picture() const {
    ImageF pixels(camera.width, camera.height, 3);
    const Rigid3 object_from_camera = camera_from_object.inverse();
    for (int y = 0; y < camera.height; ++y)
      for (int x = 0; x < camera.width; ++x) {
        Eigen::Vector3f sum = Eigen::Vector3f::Zero();
        for (int j = -3; j <= 3; ++j)
          for (int i = -3; i <= 3; ++i)
            sum += colour(object_from_camera.translation,
                          object_from_camera.rotation * Eigen::Vector3d((x + i / 7.0 - camera.cx) / camera.fx,
                                                                        (y + j / 7.0 - camera.cy) / camera.fy, 1));
        for (int c = 0; c < 3; ++c) pixels.at(x, y, c) = sum[c] / 49;
      }
    return pixels;
  }

  Eigen::Vector3f floor_colour{0.02f, 0.5f, 0.7f}, upper_colour{0.9f, 0.1f, 0};
};

TEST(Resampling, BesideAnotherSurfaceASampleHasItsOwnColourExactly) {
  const TwoSquares scene;
  Capture capture = capture_of(scene.picture());
  ImageU8 mask(240, 180, 1, 255);
  for (int y = 0; y < 180; ++y)
    for (int x = 0; x < 240; ++x)
      if (std::abs(2 * x + y - 280) < 14) {  // a glaring strip across both
        mask.at(x, y) = 0;
        const float glare[] = {50, 50, 50};
        std::memcpy(capture.image.bytes.data() + y * capture.image.stride + 12 * x, glare, 12);
      }
  // Samples 0.7 to 5 pixels apart: the kernel, and levels of half and a quarter of the size.
  std::size_t beside[2] = {0, 0};
  for (const int n : {3, 8, 20})
    for (const int erosion : {0, 1})
      for (const Sampling sampling : {Sampling::kCubic, Sampling::kLinear}) {
        const MapLayout maps(std::vector<std::uint8_t>(scene.mesh.triangles.size(), static_cast<std::uint8_t>(n)));
        SampleVisibility visibility(scene.mesh, maps, {.erosion_px = erosion});
        const SurfaceView& view = visibility.look(scene.camera, scene.camera_from_object, mask);
        RadianceImage image;
        image.load(capture, view);
        Eigen::Matrix3Xf encoded(3, lattice_samples(n));
        for (std::size_t t = 0; t < scene.mesh.triangles.size(); ++t) {
          resample({image, view, maps, 1, sampling}, t, encoded);
          const bool upper = scene.mesh.corner(t, 0).z() > 0;
          const Eigen::Vector3f colour =
              (upper ? scene.upper_colour : scene.floor_colour).unaryExpr([](float v) { return srgb_encode(v); });
          for (std::size_t s = maps.first_sample(t); s < maps.first_sample(t + 1); ++s) {
            if (!view.visible[s]) continue;
            const std::size_t in_triangle = s - maps.first_sample(t);
            const SampleProjection::Places places = view.places->of(t);
            const Eigen::Vector2f pixel(places.x[in_triangle], places.y[in_triangle]);
            beside[upper] +=
                view.from_edge.at(static_cast<int>(pixel.x() + 0.5f), static_cast<int>(pixel.y() + 0.5f)) == 1;
            ASSERT_LT((encoded.col(static_cast<Eigen::Index>(in_triangle)) - colour).cwiseAbs().maxCoeff(), 5e-5f)
                << n << ' ' << erosion << ' ' << pixel.transpose();
          }
        }
      }
  EXPECT_GT(std::min(beside[0], beside[1]), 400u);
}

TEST(Resampling, LinearSamplingIsTheMeanOfTheFourPixelsRound) {
  const ImageF pixels = noise(8, 8);
  const RadianceImage image(pixels);
  const auto pixel = [&](int x, int y) { return Eigen::Map<const Eigen::Vector3f>(pixels.pixel(x, y)); };
  const Eigen::Vector3f mean = (pixel(3, 4) + pixel(4, 4) + pixel(3, 5) + pixel(4, 5)) / 4;
  EXPECT_LT((image.sample({3.5f, 4.5f}, 1, Sampling::kLinear) - mean).norm(), 1e-6f);
}

TEST(Resampling, SamplesAreDividedByTheGainAndEncodedAndHiddenOnesAreLeftAlone) {
  Mesh mesh;
  mesh.vertices = {{2, 3, 1}, {6, 3, 1}, {10, 3, 1}, {11, 4, 1}};  // pixels
  mesh.triangles = {{0, 1, 2}, {1, 3, 2}};
  const MapLayout maps({3, 2});
  SurfaceView view;
  view.visible = {1, 0, 1, 1, 0, 1, 1, 1, 1};
  SampleProjection places(mesh, maps);
  places.use({.width = 16, .height = 8, .fx = 1, .fy = 1}, {});
  view.places = &places;
  view.visible_in_triangle = {4, 0};  // the second triangle is not looked at, whatever its samples say
  view.cosine = {1, 1};
  view.step_px = {1, 1};
  const RadianceImage image(image_of(16, 8, [](int x, int, int c) { return 0.02f * x + 0.1f * c; }));
  Eigen::Matrix3Xf encoded = Eigen::Matrix3Xf::Constant(3, 9, -7);
  const SurfaceImage from{image, view, maps, 2, Sampling::kCubic};
  resample(from, 0, encoded.leftCols(6));
  resample(from, 1, encoded.rightCols(3));
  for (int s = 0; s < 9; ++s)
    for (int c = 0; c < 3; ++c) {
      const bool read = s < 6 && view.visible[s];
      EXPECT_NEAR(encoded(c, s), read ? srgb_encode((0.02f * places.of(0).x[s] + 0.1f * c) / 2) : -7, 3e-5);
    }
}

}  // namespace
}  // namespace sheen
