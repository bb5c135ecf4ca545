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

/// An octahedron of four patches that hold random numbers: no image would give them, but every one of them must come
/// back. No image has reached the last patch; the one before is of rank 0.
std::shared_ptr<const SurfaceLightFieldSnapshot> random_model(unsigned seed) {
  auto mesh = std::make_shared<Mesh>();
  mesh->vertices = {{0.1f, 0, 0}, {0, 0.1f, 0}, {-0.1f, 0, 0}, {0, -0.1f, 0}, {0, 0, 0.1f}, {0, 0, -0.1f}};
  for (std::uint32_t i = 0; i < 4; ++i) {
    mesh->triangles.push_back({i, (i + 1) % 4, 4});
    mesh->triangles.push_back({(i + 1) % 4, i, 5});
  }
  auto maps = std::make_shared<MapLayout>(std::vector<std::uint8_t>{2, 3, 4, 5, 6, 7, 16, 2});
  auto shapes = std::make_shared<const PatchShapes>(patch_shapes(*mesh, *maps, {0, 0, 1, 1, 1, 2, 3, 3}));
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  const auto draw = [&] { return normal(random); };
  auto reflection = std::make_shared<ReflectionDrift>();
  reflection->coefficients = Harmonics::NullaryExpr(draw);
  SurfaceLightFieldSnapshot::Patches data(4);
  for (std::size_t p = 0; p < 3; ++p) {
    auto patch = std::make_shared<PatchSnapshot>();
    const PatchShape& shape = shapes->patches[p];
    const int rank = p == 2 ? 0 : 3 + 4 * static_cast<int>(p);
    patch->basis = Eigen::MatrixXf(Eigen::MatrixXf::NullaryExpr(3 * shape.samples, rank, draw));
    for (std::uint32_t s = 0; s < shape.samples; ++s) patch->shown.push_back(static_cast<std::uint8_t>(random()));
    for (std::size_t i = 0; i < shape.vertices.size(); ++i) {
      VertexInterpolant& at = patch->vertices.emplace_back();
      auto seen_from = std::make_shared<VertexViews>();
      const int views = 1 + 3 * static_cast<int>(i);
      at.weights = PackedColumns<float>::fixed_point(Eigen::MatrixXf::NullaryExpr(views, rank, draw));
      at.mean = Eigen::VectorXf::NullaryExpr(rank, draw);
      seen_from->reliability = Eigen::VectorXf::NullaryExpr(views, [&] { return 0.1f + std::abs(draw()); });
      seen_from->frame = hemisphere_frame(mesh->vertices[shape.vertices[i]].normalized());
      seen_from->directions.resize(3, views);
      for (int k = 0; k < views; ++k) {
        const Eigen::Vector3f local(0.4f * draw(), 0.4f * draw(), 1);
        seen_from->directions.col(k) = (seen_from->frame.transpose() * local).normalized();
      }
      if (p < 2 && i > 0 && i < 3) {
        at.drift = Eigen::VectorXf::NullaryExpr(rank, draw);
        seen_from->reflection = reflection;
      }
      seen_from->kernel = kViewKernels[i + 1];  // of both shapes
      at.sill = 0.001f * static_cast<float>(i);
      at.residual = 0.1f * static_cast<float>(p);
      seen_from->believe_reflection();
      seen_from->best_cosine = 1.0f / static_cast<float>(1 + i);
      at.views_folded = 10 + static_cast<int>(p);
      at.views = std::move(seen_from);
    }
    data[p] = std::move(patch);
  }
  return std::make_shared<SurfaceLightFieldSnapshot>(mesh, maps, shapes, std::move(data), 4711, ExposureField{},
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
  ASSERT_EQ(again->patches().size(), 4u);
  EXPECT_EQ(again->shapes().patch_of, model->shapes().patch_of);
  EXPECT_EQ(again->patches()[3], nullptr);
  for (std::size_t p = 0; p < 3; ++p) {
    const PatchSnapshot &a = *model->patches()[p], &b = *again->patches()[p];
    EXPECT_EQ(a.basis.unpacked(), b.basis.unpacked());
    EXPECT_EQ(a.shown, b.shown);
    ASSERT_EQ(a.vertices.size(), b.vertices.size());
    for (std::size_t i = 0; i < a.vertices.size(); ++i) {
      const VertexInterpolant &v = a.vertices[i], &w = b.vertices[i];
      EXPECT_EQ(v.views->directions, w.views->directions);
      EXPECT_EQ(v.views->reliability, w.views->reliability);
      EXPECT_EQ(v.weights.unpacked(), w.weights.unpacked());
      EXPECT_EQ(v.mean, w.mean);
      EXPECT_EQ(v.drift, w.drift);
      EXPECT_EQ(v.views->frame, w.views->frame);
      EXPECT_EQ(v.views->kernel, w.views->kernel);
      EXPECT_EQ(v.sill, w.sill);
      EXPECT_EQ(v.residual, w.residual);
      EXPECT_EQ(v.views->best_cosine, w.views->best_cosine);
      EXPECT_EQ(v.views_folded, w.views_folded);
    }
  }
  expect_same_pictures(*model, *again);
  EXPECT_EQ(load_model_metadata(folder.path() / "new" / "model"),
            (ModelMetadata{{"source", "a rig"}, {"löcher", "keine"}}));
}

TEST(ModelFiles, MapsThatHaveBecomeCoarserAreReopenedAsSuch) {
  const TempFolder folder;
  const auto model = random_model(1);
  std::vector<std::uint8_t> sides, filter;
  for (std::size_t t = 0; t < model->mesh().triangles.size(); ++t) {
    sides.push_back(static_cast<std::uint8_t>(model->maps().resolution(t)));
    filter.push_back(static_cast<std::uint8_t>(t % 2 == 0 ? sides[t] : 2 * sides[t] - 1));
  }
  const auto maps = std::make_shared<MapLayout>(sides, filter);
  save_model({model->shared_mesh(), maps, model->shared_shapes(), model->patches(), 1}, folder.path());
  const auto again = load_model(folder.path());
  for (std::size_t t = 0; t < filter.size(); ++t) EXPECT_EQ(again->maps().filter_resolution(t), filter[t]);
  expect_same_pictures(*model, *again);
}

TEST(ModelFiles, SavingAgainReplacesTheModel) {
  const TempFolder folder;
  save_model(*random_model(1), folder.path());
  const auto second = random_model(2);
  save_model(*second, folder.path(), {});
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
  const SurfaceLightFieldSnapshot empty(model->shared_mesh(), model->shared_maps(), model->shared_shapes(),
                                        SurfaceLightFieldSnapshot::Patches(4), 0);
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
  for (std::size_t p = 0; p < 2; ++p) {
    const Eigen::MatrixXf a = model->patches()[p]->basis.unpacked(), b = again->patches()[p]->basis.unpacked();
    EXPECT_LT((a - b).cwiseAbs().maxCoeff(), 5.0f / 2048);
    EXPECT_NE(a, b);
  }
}

TEST(ModelFiles, TriangulatedViewsComeBackAsTheyWere) {
  const TempFolder folder;
  const auto model = random_model(1);
  SurfaceLightFieldSnapshot::Patches patches;
  for (const auto& patch : model->patches()) {
    const auto own = patch ? std::make_shared<PatchSnapshot>(*patch) : nullptr;
    if (own)
      for (VertexInterpolant& vertex : own->vertices)
        vertex.set_triangulation(Eigen::MatrixXf::Random(own->rank(), vertex.views->directions.cols()));
    patches.push_back(own);
  }
  const SurfaceLightFieldSnapshot triangulated(model->shared_mesh(), model->shared_maps(), model->shared_shapes(),
                                               std::move(patches), 1);
  save_model(triangulated, folder.path());
  const auto opened = load_model(folder.path());
  ASSERT_TRUE(opened->triangulated());
  EXPECT_FALSE(model->triangulated());
  for (const Eigen::Vector3d& eye : {Eigen::Vector3d(0.3, -0.2, 0.9), Eigen::Vector3d(-0.4, 0.1, 0.5)}) {
    EXPECT_EQ(opened->coefficients_for(eye), triangulated.coefficients_for(eye));
    EXPECT_NE(opened->coefficients_for(eye), model->coefficients_for(eye));
  }
  expect_error<ConfigError>([&] { opened->compressed({}); }, {"delaunay"});
}

TEST(ModelFiles, WhatTheWindowPaintsRedIsKept) {
  const auto model = random_model(1);
  for (const GuidanceMethod method : {GuidanceMethod::kExpectedError, GuidanceMethod::kPaperHeuristic}) {
    const TempFolder folder;
    const SurfaceLightFieldSnapshot guided(model->shared_mesh(), model->shared_maps(), model->shared_shapes(),
                                           model->patches(), 1, {}, {}, method);
    save_model(*std::dynamic_pointer_cast<const SurfaceLightFieldSnapshot>(guided.filled()), folder.path());
    EXPECT_EQ(load_model(folder.path())->guidance_method(), method);
  }
}

/// Saves a model, changes its model.json by `change` and expects opening to fail with `words`.
template <typename Change>
void expect_refused(Change change, const std::vector<std::string>& words) {
  const TempFolder folder;
  save_model(*random_model(1), folder.path(), {});
  Json json = Json::parse(read_file(folder.path() / "model.json"));
  change(json);
  folder.write("model.json", json.dump());
  expect_error([&] { load_model(folder.path()); }, words);
}

TEST(ModelFiles, ANewerVersionIsRefusedNamingBoth) {
  expect_refused([](Json& json) { json["version"] = 7; },
                 {"model.json", "version 7", "reads version 6", "newer Sheen"});
  expect_refused([](Json& json) { json["version"] = std::int64_t(1) << 33; },
                 {"version 8589934592", "reads version 6"});
  for (const int version : {1, 2, 3, 4})
    expect_refused([&](Json& json) { json["version"] = version; },
                   {"model.json", "version " + std::to_string(version), "reads version 6", "again"});
  expect_refused([](Json& json) { json["version"] = 0; }, {"model.json", "version"});
  expect_refused([](Json& json) { json["version"] = "1"; }, {"model.json", "version", "whole number"});
}

TEST(ModelFiles, EveryWrongFieldIsNamed) {
  expect_refused([](Json& json) { json = Json::array(); }, {"model.json", "no surface light field"});
  expect_refused([](Json& json) { json["format"] = "another"; }, {"model.json", "no surface light field"});
  expect_refused([](Json& json) { json.erase("patches"); }, {"model.json", "patches"});
  expect_refused([](Json& json) { json.erase("vertices"); }, {"model.json", "vertices"});
  expect_refused([](Json& json) { json["guidance"] = "red"; }, {"model.json", "guidance", "paper-heuristic"});
  expect_refused([](Json& json) { json["guidance"] = 1; }, {"model.json", "guidance", "text"});
  expect_refused([](Json& json) { json["patch_of_triangle"].erase(0); }, {"patch_of_triangle", "7", "8"});
  expect_refused([](Json& json) { json["patch_of_triangle"][5] = 8; }, {"patch_of_triangle", "entry 5"});
  expect_refused([](Json& json) { json["patch_of_triangle"][5] = 1; }, {"patch_of_triangle", "patch 2", "no triangle"});
  expect_refused([](Json& json) { json.erase("id"); }, {"model.json", "id"});
  expect_refused([](Json& json) { json["id"] = "0"; }, {"maps.exr", "does not belong"});
  expect_refused([](Json& json) { json["mesh_hash"] = "0"; }, {"mesh.ply", "not the mesh"});
  expect_refused([](Json& json) { json["lattice_resolution"].erase(0); }, {"lattice_resolution", "7", "8"});
  expect_refused([](Json& json) { json["lattice_resolution"][3] = 1; }, {"lattice_resolution", "entry 3"});
  expect_refused([](Json& json) { json["lattice_resolution"][3] = 256; }, {"lattice_resolution", "entry 3"});
  expect_refused([](Json& json) { json["lattice_resolution"][3] = 4; }, {"maps.exr", "pixels instead of"});
  expect_refused([](Json& json) { json["filter_resolution"] = {4, 4}; }, {"filter_resolution", "2", "8"});
  expect_refused([](Json& json) { json["filter_resolution"] = Json(8, 1); }, {"filter_resolution", "entry 0"});
  expect_refused([](Json& json) { json["filter_resolution"] = 9; }, {"filter_resolution"});
  expect_refused([](Json& json) { json["patches"]["patch"][0] = 4; }, {"patch", "entry 0"});
  expect_refused([](Json& json) { json["patches"]["patch"][1] = 0; }, {"patch", "rise"});
  expect_refused([](Json& json) { json["patches"]["rank"].push_back(1); }, {"rank", "4", "3"});
  expect_refused([](Json& json) { json["patches"]["rank"][0] = 101; }, {"rank", "entry 0"});
  expect_refused([](Json& json) { json["patches"]["rank"][1] = 8; }, {"maps.exr", "surface.rank07", "missing"});
  expect_refused([](Json& json) { json["patches"]["rank"][2] = 1e9; }, {"rank", "entry 2"});
  expect_refused([](Json& json) { json["vertices"]["views"][2] = 1000; }, {"maps.exr", "views", "pixels instead of"});
  expect_refused([](Json& json) { json["vertices"]["views"][2] = -1; }, {"views", "entry 2"});
  expect_refused([](Json& json) { json["vertices"]["views"][2] = 1000000000; }, {"views", "entry 2"});
  expect_refused([](Json& json) { json["vertices"]["views"].erase(0); }, {"views", "11", "12"});
  expect_refused([](Json& json) { json["vertices"]["kernel_scale_rad"][2] = 0; }, {"kernel_scale_rad", "entry 2"});
  expect_refused([](Json& json) { json["vertices"]["sill"][2] = -1; }, {"sill", "entry 2"});
  expect_refused([](Json& json) { json["vertices"]["residual"][2] = nullptr; }, {"residual", "entry 2"});
  expect_refused([](Json& json) { json.erase("reflection"); }, {"reflection", "must be a list"});
  expect_refused([](Json& json) { json["reflection"].push_back(1); }, {"reflection", "50", "49"});
  expect_refused([](Json& json) { json["reflection"][3] = "x"; }, {"reflection", "entry 3"});
}

TEST(ModelFiles, BrokenAndMissingFilesAreNamed) {
  const TempFolder folder;
  const auto model = random_model(1);
  save_model(*model, folder.path(), {});
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
  refused({"maps.exr", "\"vertices\""});
  for (std::size_t size = 0; size < json.size() - 1; size += 1 + json.size() / 61) {
    folder.write("model.json", json.substr(0, size));
    refused({"model.json"});
  }
  folder.write("model.json", std::string(100000, '['));
  refused({"model.json", "JSON"});
  folder.write("mesh.ply", mesh.substr(0, mesh.size() - 1));
  refused({"mesh.ply"});
  // A save cut short: the maps are new, the description is old.
  save_model(*random_model(2), folder.path(), {{"a", "b"}});
  folder.write("model.json", json);
  refused({"maps.exr", "does not belong"});
  expect_same_pictures(*model, *load_model(folder.path()));
  expect_error([&] { load_model(folder.path() / "none"); }, {"none", "no such folder"});
}

TEST(ModelFiles, RanksThatTheMapsCannotHoldAreNotGivenTheMemory) {
  const TempFolder folder;
  save_model(*random_model(1), folder.path(), {});
  // A part for each rank, of a pixel; and lattices of 33,000 samples that ask for 800 MB.
  ExrFile maps = read_exr(folder.path() / "maps.exr");
  for (int rank = 10; rank < 99; ++rank)
    maps.parts.push_back({"surface.rank" + std::to_string(rank), {"R", "G", "B"}, ImageF(1, 1, 3)});
  for (const char* rank : {"07", "08", "09"})
    maps.parts.push_back({std::string("surface.rank") + rank, {"R", "G", "B"}, ImageF(1, 1, 3)});
  write_exr(folder.path() / "maps.exr", maps);
  Json json = Json::parse(read_file(folder.path() / "model.json"));
  for (Json& resolution : json["lattice_resolution"]) resolution = 255;
  for (Json& rank : json["patches"]["rank"]) rank = 99;
  folder.write("model.json", json.dump());
  expect_error([&] { load_model(folder.path()); }, {"maps.exr", "too small for", "MB of surface maps"});
}

TEST(ModelFiles, LatticesOfMoreSamplesThanCanBeCountedAreRefused) {
  const TempFolder folder;
  auto mesh = std::make_shared<Mesh>();
  mesh->vertices = {{0.1f, 0, 0}, {0, 0.1f, 0}, {0, 0, 0.1f}};
  mesh->triangles.assign(30'000, {0, 1, 2});  // of all together more samples than 32 bits count
  const auto maps = std::make_shared<MapLayout>(std::vector<std::uint8_t>(30'000, 2));
  const auto shapes = std::make_shared<const PatchShapes>(
      patch_shapes(*mesh, *maps, std::vector<std::uint32_t>(mesh->triangles.size(), 0)));
  save_model({mesh, maps, shapes, SurfaceLightFieldSnapshot::Patches(1), 1}, folder.path());
  Json json = Json::parse(read_file(folder.path() / "model.json"));
  for (Json& resolution : json["lattice_resolution"]) resolution = 255;
  folder.write("model.json", json.dump());
  expect_error([&] { load_model(folder.path()); }, {"model.json", "lattice_resolution", "samples, more than"});
}

TEST(ModelFiles, DamagedMapsAreReadOrRefused) {
  const TempFolder folder;
  save_model(*random_model(1), folder.path(), {});
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
  auto data = model->patches();
  auto broken = std::make_shared<PatchSnapshot>(*data[1]);
  Eigen::MatrixXf basis = broken->basis.unpacked();
  basis(3, 1) = std::nanf("");
  broken->basis = basis;
  data[1] = broken;
  save_model({model->shared_mesh(), model->shared_maps(), model->shared_shapes(), data, 1}, folder.path());
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
