// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/files/model_files.h"

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <random>

#include "common/base/files.h"
#include "reconstructor/surface/view_hemisphere.h"
#include "support/expect_error.h"
#include "support/temp_folder.h"

namespace sheen {
namespace {

using Json = nlohmann::json;

std::vector<PosedCamera> two_cameras() {
  const Camera camera{.width = 640, .height = 480, .fx = 800, .fy = 801, .cx = 319.5, .cy = 239.25};
  return {{camera, look_at({1, 0.3, 0.2}, {0, 0, 0}, {0, 0, 1})},
          {camera, look_at({-1, 0.1, 0.4}, {0, 0, 0}, {0, 0, 1})}};
}

/// An octahedron whose rings hold random numbers: no image would give them, but every one of them must come back. The
/// last vertex has no ring, the one before a ring of rank 0.
std::shared_ptr<const SurfaceLightFieldSnapshot> random_model(unsigned seed) {
  auto mesh = std::make_shared<Mesh>();
  mesh->vertices = {{0.1f, 0, 0}, {0, 0.1f, 0}, {-0.1f, 0, 0}, {0, -0.1f, 0}, {0, 0, 0.1f}, {0, 0, -0.1f}};
  for (std::uint32_t i = 0; i < 4; ++i) {
    mesh->triangles.push_back({i, (i + 1) % 4, 4});
    mesh->triangles.push_back({(i + 1) % 4, i, 5});
  }
  auto rings = std::make_shared<VertexRings>(*mesh, std::vector<std::uint8_t>{2, 3, 4, 5, 6, 7, 16, 2});
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  std::vector<std::shared_ptr<const RingSnapshot>> data(6);
  auto reflection = std::make_shared<ReflectionDrift>();
  reflection->coefficients = Harmonics::NullaryExpr([&] { return normal(random); });
  for (int v = 0; v < 5; ++v) {
    auto ring = std::make_shared<RingSnapshot>();
    const int samples = rings->ring_samples(v), rank = v == 4 ? 0 : 1 + 2 * v, views = 1 + 3 * v;
    const auto draw = [&] { return normal(random); };
    ring->basis = Eigen::MatrixXf::NullaryExpr(3 * samples, rank, draw);
    ring->weights = Eigen::MatrixXf::NullaryExpr(rank, views, draw);
    ring->mean = Eigen::VectorXf::NullaryExpr(rank, draw);
    ring->reliability = Eigen::VectorXf::NullaryExpr(views, [&] { return 0.1f + std::abs(draw()); });
    ring->frame = hemisphere_frame(mesh->vertices[v].normalized());
    ring->directions.resize(3, views);
    for (int k = 0; k < views; ++k)
      ring->directions.col(k) =
          (ring->frame.transpose() * Eigen::Vector3f(0.4f * draw(), 0.4f * draw(), 1)).normalized();
    if (v > 0 && v < 3) {
      ring->drift = Eigen::VectorXf::NullaryExpr(rank, draw);
      ring->reflection = reflection;
    }
    ring->kernel = kViewKernels[v + 1];  // of both shapes
    for (int s = 0; s < samples; ++s) ring->shown.push_back(static_cast<std::uint8_t>(random()));
    ring->sill = 0.001f * v;
    ring->residual = 0.1f * v;
    ring->best_cosine = 1.0f / (1 + v);
    ring->views_folded = 10 + v;
    data[v] = std::move(ring);
  }
  return std::make_shared<SurfaceLightFieldSnapshot>(mesh, rings, std::move(data), 4711, ExposureField{},
                                                     two_cameras());
}

void expect_same_pictures(const SurfaceLightFieldSnapshot& a, const SurfaceLightFieldSnapshot& b) {
  for (const Eigen::Vector3d& eye : {Eigen::Vector3d(1, 0.3, 0.2), {-0.2, 0.4, 0.9}, {0.1, -1, -0.3}}) {
    const auto shader_a = a.shader_for({eye}), shader_b = b.shader_for({eye});
    for (std::uint32_t t = 0; t < a.mesh().triangles.size(); ++t) {
      const SurfaceQuality quality_a = shader_a->quality(t), quality_b = shader_b->quality(t);
      EXPECT_EQ(quality_a.error, quality_b.error);
      EXPECT_EQ(quality_a.reason(), quality_b.reason());
      for (float u = 0; u <= 1; u += 0.125f)
        for (float v = 0; u + v <= 1; v += 0.125f) {
          const SurfaceSample sa = shader_a->shade(t, u, v), sb = shader_b->shade(t, u, v);
          ASSERT_EQ(sa.rgb, sb.rgb) << "triangle " << t;
          ASSERT_EQ(sa.state, sb.state);
        }
    }
  }
}

TEST(ModelFiles, AReopenedModelIsTheSameBitForBit) {
  const TempFolder folder;
  const auto model = random_model(1);
  save_model(*model, folder.path() / "new" / "model", {{"source", "a rig"}, {"löcher", "keine"}});
  const auto again = load_model(folder.path() / "new" / "model");
  EXPECT_EQ(again->mesh().vertices, model->mesh().vertices);
  EXPECT_EQ(again->mesh().triangles, model->mesh().triangles);
  ASSERT_EQ(again->ring_data().size(), 6u);
  EXPECT_EQ(again->ring_data()[5], nullptr);
  for (int v = 0; v < 5; ++v) {
    const RingSnapshot &a = *model->ring_data()[v], &b = *again->ring_data()[v];
    EXPECT_EQ(a.basis, b.basis);
    EXPECT_EQ(a.directions, b.directions);
    EXPECT_EQ(a.weights, b.weights);
    EXPECT_EQ(a.mean, b.mean);
    EXPECT_EQ(a.frame, b.frame);
    EXPECT_EQ(a.kernel, b.kernel);
    EXPECT_EQ(a.shown, b.shown);
    EXPECT_EQ(a.sill, b.sill);
    EXPECT_EQ(a.residual, b.residual);
    EXPECT_EQ(a.best_cosine, b.best_cosine);
    EXPECT_EQ(a.views_folded, b.views_folded);
  }
  expect_same_pictures(*model, *again);
  EXPECT_EQ(load_model_metadata(folder.path() / "new" / "model"),
            (ModelMetadata{{"source", "a rig"}, {"löcher", "keine"}}));
}

TEST(ModelFiles, SavingAgainReplacesTheModel) {
  const TempFolder folder;
  save_model(*random_model(1), folder.path());
  const auto second = random_model(2);
  save_model(*second, folder.path(), {}, {.view_map = 0});
  expect_same_pictures(*second, *load_model(folder.path()));
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 3) << "nothing unfinished is left";
}

TEST(ModelFiles, ASaveThatIsStoppedAnywhereLeavesTheOlderModel) {
  struct Enough {};
  const TempFolder folder;
  const auto old = random_model(1), next = random_model(2);
  const auto here = folder.path() / "model";
  save_model(*old, here);
  std::size_t steps = 0, last = 0;
  save_model(*next, folder.path() / "next", {}, {.progress = [&](std::size_t done, std::size_t all) {
    EXPECT_GE(done, last);
    EXPECT_LT(done, all);
    last = done;
    ++steps;
  }});
  ASSERT_GT(steps, 5u);
  for (std::size_t stop = 1; stop <= steps; ++stop) {
    const auto until = [n = std::size_t{0}, stop](std::size_t, std::size_t) mutable {
      if (++n == stop) throw Enough();
    };
    EXPECT_THROW(save_model(*next, here, {}, {.progress = until}), Enough);
    EXPECT_THROW(save_model(*next, folder.path() / "new", {}, {.progress = until}), Enough);
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(here), {}), 3) << "something unfinished is left";
    EXPECT_FALSE(std::filesystem::exists(folder.path() / "new"));
  }
  expect_same_pictures(*old, *load_model(here));
  // Killed in the middle: what it left does not hinder the next one.
  std::filesystem::create_directory(here / ".unfinished");
  std::ofstream(here / ".unfinished" / "maps.exr") << "half";
  expect_same_pictures(*old, *load_model(here));
  save_model(*next, here);
  expect_same_pictures(*next, *load_model(here));
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(here), {}), 3);
}

TEST(ModelFiles, AModelThatNoImageReached) {
  const TempFolder folder;
  const auto model = random_model(1);
  const SurfaceLightFieldSnapshot empty(model->shared_mesh(), model->shared_rings(),
                                        std::vector<std::shared_ptr<const RingSnapshot>>(6), 0);
  save_model(empty, folder.path());
  const auto again = load_model(folder.path());
  EXPECT_EQ(again->max_rank(), 0);
  EXPECT_EQ(again->shader_for({{1, 0, 0}})->shade(0, 0.2f, 0.2f).state, SampleState::kUnseen);
}

TEST(ModelFiles, HalfPrecisionIsClose) {
  const TempFolder folder;
  const auto model = random_model(1);
  save_model(*model, folder.path(), {}, {.surface = ExrPrecision::kHalf});
  const auto again = load_model(folder.path());
  for (int v = 0; v < 4; ++v) {
    const Eigen::MatrixXf &a = model->ring_data()[v]->basis, &b = again->ring_data()[v]->basis;
    EXPECT_LT((a - b).cwiseAbs().maxCoeff(), 5.0f / 2048);
    EXPECT_NE(a, b);
  }
}

TEST(ModelFiles, ViewMapsHoldTheCoefficients) {
  const TempFolder folder;
  const auto model = random_model(1);
  save_model(*model, folder.path());
  const ExrFile maps = read_exr(folder.path() / "maps.exr");
  ASSERT_NE(maps.find("view.rank06"), nullptr);
  EXPECT_EQ(maps.find("view.rank07"), nullptr);
  EXPECT_EQ(maps.parts[0].name, "surface.rank00");
  const ImageF& image = maps.find("view.rank06")->image;  // five rings: tiles 3 across, 2 down
  ASSERT_EQ(image.width(), 96);
  ASSERT_EQ(image.height(), 64);
  const RingSnapshot& ring = *model->ring_data()[3];  // the only one of rank 7: left tile of the second row
  const float step = 2.0f / 32;
  for (const auto& [x, y] : {std::pair(16, 16), {10, 20}, {25, 9}}) {
    const Eigen::Vector2f p(step * (x + 0.5f) - 1, step * (y + 0.5f) - 1);
    const Eigen::Vector3f local(p.x(), p.y(), std::sqrt(1 - p.squaredNorm()));
    const float expected = ring.coefficients(ring.frame.transpose() * local)[6];
    EXPECT_NEAR(image.at(x, 32 + y), expected, 1e-3 * (1 + std::abs(expected)));
  }
  EXPECT_EQ(image.at(16, 16), 0) << "another ring's tile: it has no such rank";
}

/// Saves a model, changes its model.json by `change` and expects opening to fail with `words`.
template <typename Change>
void expect_refused(Change change, const std::vector<std::string>& words) {
  const TempFolder folder;
  save_model(*random_model(1), folder.path(), {}, {.view_map = 0});
  Json json = Json::parse(read_file(folder.path() / "model.json"));
  change(json);
  folder.write("model.json", json.dump());
  expect_error([&] { load_model(folder.path()); }, words);
}

TEST(ModelFiles, ANewerVersionIsRefusedNamingBoth) {
  expect_refused([](Json& json) { json["version"] = 5; },
                 {"model.json", "version 5", "reads version 4", "newer Sheen"});
  expect_refused([](Json& json) { json["version"] = std::int64_t(1) << 33; },
                 {"version 8589934592", "reads version 4"});
  for (const int version : {1, 2, 3})
    expect_refused([&](Json& json) { json["version"] = version; },
                   {"model.json", "version " + std::to_string(version), "reads version 4", "again"});
  expect_refused([](Json& json) { json["version"] = 0; }, {"model.json", "version"});
  expect_refused([](Json& json) { json["version"] = "1"; }, {"model.json", "version", "whole number"});
}

TEST(ModelFiles, EveryWrongFieldIsNamed) {
  expect_refused([](Json& json) { json = Json::array(); }, {"model.json", "no surface light field"});
  expect_refused([](Json& json) { json["format"] = "another"; }, {"model.json", "no surface light field"});
  expect_refused([](Json& json) { json.erase("rings"); }, {"model.json", "rings"});
  expect_refused([](Json& json) { json.erase("id"); }, {"model.json", "id"});
  expect_refused([](Json& json) { json["id"] = "0"; }, {"maps.exr", "does not belong"});
  expect_refused([](Json& json) { json["mesh_hash"] = "0"; }, {"mesh.ply", "not the mesh"});
  expect_refused([](Json& json) { json["lattice_resolution"].erase(0); }, {"lattice_resolution", "7", "8"});
  expect_refused([](Json& json) { json["lattice_resolution"][3] = 1; }, {"lattice_resolution", "entry 3"});
  expect_refused([](Json& json) { json["lattice_resolution"][3] = 256; }, {"lattice_resolution", "entry 3"});
  expect_refused([](Json& json) { json["lattice_resolution"][3] = 4; }, {"maps.exr", "pixels instead of"});
  expect_refused([](Json& json) { json["rings"]["vertex"][0] = 6; }, {"vertex", "entry 0"});
  expect_refused([](Json& json) { json["rings"]["vertex"][1] = 0; }, {"vertex", "rise"});
  expect_refused([](Json& json) { json["rings"]["rank"].push_back(1); }, {"rank", "6", "5"});
  expect_refused([](Json& json) { json["rings"]["rank"][0] = 101; }, {"rank", "entry 0"});
  expect_refused([](Json& json) { json["rings"]["rank"][3] = 8; }, {"maps.exr", "surface.rank07", "missing"});
  expect_refused([](Json& json) { json["rings"]["rank"][2] = 1e9; }, {"rank", "entry 2"});
  expect_refused([](Json& json) { json["rings"]["views"][2] = 1000; }, {"maps.exr", "views", "pixels instead of"});
  expect_refused([](Json& json) { json["rings"]["views"][2] = -1; }, {"views", "entry 2"});
  expect_refused([](Json& json) { json["rings"]["views"][2] = 1000000000; }, {"views", "entry 2"});
  expect_refused([](Json& json) { json["rings"]["kernel_scale_rad"][2] = 0; }, {"kernel_scale_rad", "entry 2"});
  expect_refused([](Json& json) { json["rings"]["sill"][2] = -1; }, {"sill", "entry 2"});
  expect_refused([](Json& json) { json["rings"]["residual"][2] = nullptr; }, {"residual", "entry 2"});
  expect_refused([](Json& json) { json.erase("reflection"); }, {"reflection", "must be a list"});
  expect_refused([](Json& json) { json["reflection"].push_back(1); }, {"reflection", "50", "49"});
  expect_refused([](Json& json) { json["reflection"][3] = "x"; }, {"reflection", "entry 3"});
}

TEST(ModelFiles, BrokenAndMissingFilesAreNamed) {
  const TempFolder folder;
  const auto model = random_model(1);
  save_model(*model, folder.path(), {}, {.view_map = 0});
  const std::string json = read_file(folder.path() / "model.json"), maps = read_file(folder.path() / "maps.exr"),
                    mesh = read_file(folder.path() / "mesh.ply");
  const auto refused = [&](const std::vector<std::string>& words) {
    expect_error([&] { load_model(folder.path()); }, words);
    folder.write("model.json", json);
    folder.write("maps.exr", maps);
    folder.write("mesh.ply", mesh);
  };
  for (const char* name : {"model.json", "maps.exr", "mesh.ply"}) {
    std::filesystem::remove(folder.path() / name);
    refused({name});
  }
  for (std::size_t size = 0; size < maps.size(); size += 1 + maps.size() / 61) {
    folder.write("maps.exr", maps.substr(0, size));
    refused({"maps.exr"});
  }
  folder.write("maps.exr", maps.substr(0, maps.size() - 30));
  refused({"maps.exr", "\"rings\""});
  for (std::size_t size = 0; size < json.size() - 1; size += 1 + json.size() / 61) {
    folder.write("model.json", json.substr(0, size));
    refused({"model.json"});
  }
  folder.write("model.json", std::string(100000, '['));
  refused({"model.json", "JSON"});
  folder.write("mesh.ply", mesh.substr(0, mesh.size() - 1));
  refused({"mesh.ply"});
  // A save cut short: the maps are new, the description is old.
  save_model(*random_model(2), folder.path(), {{"a", "b"}}, {.view_map = 0});
  folder.write("model.json", json);
  refused({"maps.exr", "does not belong"});
  expect_same_pictures(*model, *load_model(folder.path()));
  expect_error([&] { load_model(folder.path() / "none"); }, {"none", "no such folder"});
}

TEST(ModelFiles, RanksThatTheMapsCannotHoldAreNotGivenTheMemory) {
  const TempFolder folder;
  save_model(*random_model(1), folder.path(), {}, {.view_map = 0});
  // A part for each rank, of a pixel; and lattices of 33,000 samples that ask for 800 MB.
  ExrFile maps = read_exr(folder.path() / "maps.exr");
  for (int rank = 10; rank < 99; ++rank)
    maps.parts.push_back({"surface.rank" + std::to_string(rank), {"R", "G", "B"}, ImageF(1, 1, 3)});
  for (const char* rank : {"07", "08", "09"})
    maps.parts.push_back({std::string("surface.rank") + rank, {"R", "G", "B"}, ImageF(1, 1, 3)});
  write_exr(folder.path() / "maps.exr", maps);
  Json json = Json::parse(read_file(folder.path() / "model.json"));
  for (Json& resolution : json["lattice_resolution"]) resolution = 255;
  for (Json& rank : json["rings"]["rank"]) rank = 99;
  folder.write("model.json", json.dump());
  expect_error([&] { load_model(folder.path()); }, {"maps.exr", "too small for", "MB of surface maps"});
}

TEST(ModelFiles, LatticesOfMoreSamplesThanCanBeCountedAreRefused) {
  const TempFolder folder;
  auto mesh = std::make_shared<Mesh>();
  mesh->vertices = {{0.1f, 0, 0}, {0, 0.1f, 0}, {0, 0, 0.1f}};
  mesh->triangles.assign(30'000, {0, 1, 2});  // all of one ring: its samples would not fit 32 bits
  const auto rings = std::make_shared<VertexRings>(*mesh, std::vector<std::uint8_t>(30'000, 2));
  save_model({mesh, rings, std::vector<std::shared_ptr<const RingSnapshot>>(3), 1}, folder.path());
  Json json = Json::parse(read_file(folder.path() / "model.json"));
  for (Json& resolution : json["lattice_resolution"]) resolution = 255;
  folder.write("model.json", json.dump());
  expect_error([&] { load_model(folder.path()); }, {"model.json", "lattice_resolution", "samples, more than"});
}

TEST(ModelFiles, DamagedMapsAreReadOrRefused) {
  const TempFolder folder;
  save_model(*random_model(1), folder.path(), {}, {.view_map = 0});
  const std::string maps = read_file(folder.path() / "maps.exr");
  int refused = 0, tried = 0;
  for (std::size_t i = 0; i < maps.size(); i += 1 + maps.size() / 211, ++tried) {
    std::string damaged = maps;
    damaged[i] = static_cast<char>(damaged[i] ^ 0x5a);
    folder.write("maps.exr", damaged);
    try {
      load_model(folder.path());
    } catch (const FileError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, tried / 2) << "compressed data carry checksums";
}

TEST(ModelFiles, AValueThatIsNotFiniteIsRefused) {
  const TempFolder folder;
  const auto model = random_model(1);
  auto data = model->ring_data();
  auto broken = std::make_shared<RingSnapshot>(*data[2]);
  broken->basis(3, 1) = std::nanf("");
  data[2] = broken;
  save_model({model->shared_mesh(), model->shared_rings(), data, 1}, folder.path());
  expect_error([&] { load_model(folder.path()); }, {"maps.exr", "surface.rank01", "finite"});
}

TEST(ModelFiles, WhereNothingCanBeWritten) {
  const auto model = random_model(1);
  expect_error([&] { save_model(*model, "/dev/full/model"); }, {"/dev/full/model", "cannot be created"});
  const TempFolder folder;
  expect_error([&] { save_model(*model, folder.path(), {{"key", "\xff"}}); }, {"model.json", "metadata"});
}

}  // namespace
}  // namespace sheen
