// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/scene/scene_config.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <memory>
#include <set>
#include <sstream>

#include "common/base/content_hash.h"
#include "common/base/errors.h"
#include "common/base/files.h"
#include "reconstructor/capture/reconstruction.h"
#include "reconstructor/models/surface_light_field/surface_light_field.h"
#include "reconstructor/studies/tradeoff.h"
#include "tests/reconstructor/models/surface_light_field/light_field_checks.h"
#include "tests/support/expect_error.h"
#include "tests/support/temp_folder.h"

namespace sheen {
namespace {

SurfaceLightFieldOptions load_options(const std::filesystem::path& file) {
  return light_field_options(*load_scene_config(file).settings, "the test");
}

TEST(SceneConfig, TheExampleIsRead) {
  EXPECT_STREQ(load_scene_config(SHEEN_EXAMPLES "/scene.toml").kind->name(), "surface_light_field");
}

TEST(SceneConfig, ThePapersWaysAreAnExampleToo) {
  const SurfaceLightFieldOptions paper = load_options(SHEEN_EXAMPLES "/paper.toml");
  EXPECT_EQ(paper.patch.interpolation.method, ViewMethod::kDelaunay);
  EXPECT_EQ(paper.patch.factor.imputation, Imputation::kLeastSquares);
  EXPECT_EQ(paper.visibility.test, VisibilityTest::kVertices);
  EXPECT_EQ(paper.guidance, GuidanceMethod::kPaperHeuristic);
  EXPECT_NE(paper.no_small_form(), "");
  EXPECT_EQ(load_options(SHEEN_EXAMPLES "/scene.toml").no_small_form(), "");
}

TEST(SceneConfig, TheExampleHasEveryKeyWithItsDefault) {
  const std::string text = read_file(SHEEN_EXAMPLES "/scene.toml");
  SurfaceLightFieldOptions example = load_options(SHEEN_EXAMPLES "/scene.toml"), defaults;
  const std::vector<SettingKey> read = example.keys(), known = defaults.keys();
  for (std::size_t i = 0; i < known.size(); ++i) {
    EXPECT_NE(text.find("\n" + known[i].name + " = "), std::string::npos) << known[i].name;
    EXPECT_EQ(read[i].get(), known[i].get()) << known[i].name;
  }
}

TEST(SceneConfig, AllKeysAreTaken) {
  const TempFolder folder;
  const auto o = load_options(folder.write("scene.toml", R"(
model = "surface_light_field"
[images]
hold_out_every = 0
exposure = "estimate"
erosion_px = 3
[surface_light_field]
surface_map = 12
max_rank = 5
tolerance = 0.02
[surface_light_field.advanced]
internal_rank = 9
block = 4
max_views = 30
min_visible = 0.25
)"));
  EXPECT_EQ(o.surface_map, 12);
  EXPECT_EQ(o.patch.factor.max_rank, 5);
  EXPECT_EQ(o.patch.factor.internal_rank, 9);
  EXPECT_EQ(o.patch.factor.block, 4);
  EXPECT_EQ(o.patch.factor.tolerance, 0.02);
  EXPECT_EQ(o.patch.max_views, 30);
  EXPECT_EQ(o.patch.min_visible, 0.25);
  EXPECT_EQ(o.hold_out_every, 0);
  EXPECT_EQ(o.exposure, ExposureCompensation::kEstimate);
  EXPECT_EQ(o.visibility.erosion_px, 3);
}

TEST(SceneConfig, WhatIsWrittenIsReadAgain) {
  const TempFolder folder;
  SurfaceLightFieldOptions options;
  options.surface_map = 12;
  options.hold_out_every = 0;
  options.exposure = ExposureCompensation::kEstimate;
  options.patch.factor = {.max_rank = 5, .tolerance = 1.25e-7};
  options.patch.max_views = 30;
  options.patch.min_visible = 1;
  options.visibility.erosion_px = 3;
  const std::string text = to_toml(options);
  const auto o = load_options(folder.write("scene.toml", text));
  EXPECT_EQ(to_toml(o), text);
  EXPECT_EQ(o.surface_map, 12);
  EXPECT_EQ(o.patch.factor.tolerance, 1.25e-7);
  EXPECT_EQ(o.exposure, ExposureCompensation::kEstimate);
  EXPECT_NE(to_toml(SurfaceLightFieldOptions{}), text);
}

TEST(SceneConfig, EverySettingOfASweepIsASceneFileOfItsOwn) {
  const TempFolder folder;
  std::set<std::string> texts;
  for (const Setting& setting : tradeoff_settings({}, false)) {
    const std::string text = to_toml(setting.options);
    const auto o = load_options(folder.write("scene.toml", text));
    EXPECT_EQ(to_toml(o), text) << setting.name;
    EXPECT_NO_THROW(SurfaceLightField(std::make_shared<Mesh>(), o)) << setting.name;
    texts.insert(text);
  }
  EXPECT_EQ(texts.size(), tradeoff_settings({}, false).size()) << "what is swept has keys of its own";
}

TEST(SceneConfig, WhatIsNotSaidKeepsItsDefault) {
  const TempFolder folder;
  const SurfaceLightFieldOptions defaults;
  for (const char* text : {"", "# nothing\n", "[surface_light_field]\n"}) {
    const auto o = load_options(folder.write("scene.toml", text));
    EXPECT_EQ(o.surface_map, defaults.surface_map);
    EXPECT_EQ(o.patch.factor.tolerance, defaults.patch.factor.tolerance);
    EXPECT_EQ(o.exposure, defaults.exposure);
  }
}

TEST(SceneConfig, AWholeNumberIsANumber) {
  const TempFolder folder;
  const auto o = load_options(folder.write(
      "s.toml", "[surface_light_field]\ntolerance = 0\n[surface_light_field.advanced]\nmin_visible = 1\n"));
  EXPECT_EQ(o.patch.factor.tolerance, 0);
  EXPECT_EQ(o.patch.min_visible, 1);
}

TEST(SceneConfig, ErrorsNameFileLineAndKey) {
  const TempFolder folder;
  const auto expect_refused = [&](const char* text, const std::vector<std::string>& words) {
    const auto file = folder.write("my scene.toml", text);
    expect_error<ConfigError>([&] { load_scene_config(file); }, words);
  };
  const std::string name = (folder.path() / "my scene.toml").string();
  expect_refused("[surface_light_field]\n\nmax_ranks = 3\n", {name + ":3", "unknown key max_ranks"});
  expect_refused("[surface_light_field]\nmax_rank = 3\n[surface_light_feild]\n", {name + ":3", "surface_light_feild"});
  expect_refused("max_rank = 3\n", {name + ":1", "max_rank"});
  expect_refused("[surface_light_field]\nmax_rank = 3.5\n", {name + ":2", "max_rank", "whole number"});
  expect_refused("[surface_light_field]\nmax_rank = \"3\"\n", {name + ":2", "max_rank", "whole number"});
  expect_refused("[surface_light_field]\nsurface_map = 4294967304\n", {name + ":2", "surface_map", "whole number"});
  expect_refused("[surface_light_field]\ntolerance = true\n", {name + ":2", "tolerance", "number"});
  expect_refused("[surface_light_field]\ntolerance = [0.1]\n", {name + ":2", "tolerance", "number"});
  expect_refused("[images]\nexposure = \"auto\"\n", {name + ":2", "exposure", "estimate"});
  expect_refused("[images]\nexposure = 1\n", {name + ":2", "exposure", "known"});
  expect_refused("[surface_light_field]\nmax_rank = 3\nmax_rank = 4\n", {name + ":3", "max_rank"});
  expect_refused("[surface_light_field]\nmax_rank =\n", {name + ":2"});
  expect_refused("surface_light_field = 1\n", {name + ":1", "surface_light_field"});
  expect_refused("[surface_light_field.deeper]\nx = 1\n", {name + ":1", "deeper"});
  expect_refused("[surface_light_field]\nadvanced = 1\n", {name + ":2", "advanced"});
  expect_refused("[surface_light_field]\nhold_out_every = 4\n", {name + ":2", "hold_out_every stands in [images]"});
  expect_refused("[surface_light_field]\nblock = 4\n", {name + ":2", "block stands in [surface_light_field.advanced]"});
  expect_refused("model = \"photo album\"\n", {name + ":1", "model", "\"surface_light_field\""});
  expect_refused("model = 3\n", {name + ":1", "model", "\"surface_light_field\""});
}

constexpr const char *kImages = "images", *kModel = "surface_light_field", *kAdvanced = "surface_light_field.advanced",
                     *kStudy = "surface_light_field.study";

/// Every key, with values that it takes, in TOML, and such as it does not.
struct KeyCase {
  const char* table;
  const char* key;
  const char* taken;
  std::vector<const char*> refused;
};
const std::vector<KeyCase>& all_keys() {
  static const std::vector<KeyCase> cases{
      {kModel, "surface_map", "12", {"1", "-4", "65"}},
      {kAdvanced, "map_scale", "0.5", {"0", "-1", "1e-300", "4.1", "nan", "inf"}},
      {kAdvanced, "map_detail", "0.1", {"-0.01", "1.1", "nan", "inf"}},
      {kImages, "sampling", "\"linear\"", {"\"\"", "\"nearest\"", "1"}},
      {kModel, "max_rank", "5", {"0", "-1", "65"}},
      {kAdvanced, "internal_rank", "40", {"3", "-1", "65"}},
      {kAdvanced, "block", "4", {"0", "33"}},
      {kModel, "tolerance", "0.02", {"-0.1", "1", "nan", "inf"}},
      {kAdvanced, "max_views", "30", {"7", "1001"}},
      {kAdvanced, "repeat_angle", "0.1", {"-0.1", "0.5", "nan"}},
      {kAdvanced, "min_visible", "0.25", {"-0.1", "1.1", "nan"}},
      {kStudy, "interpolation", "\"delaunay\"", {"\"linear\"", "1"}},
      {kStudy, "imputation", "\"least-squares\"", {"\"none\"", "1"}},
      {kStudy, "visibility", "\"vertices\"", {"\"triangles\"", "1"}},
      {kStudy, "guidance", "\"paper-heuristic\"", {"\"paper\"", "1"}},
      {kImages, "hold_out_every", "4", {"1", "-1"}},
      {kImages, "exposure", "\"off\"", {"\"auto\"", "true"}},
      {kImages, "erosion_px", "3", {"-1", "33"}},
  };
  return cases;
}

/// A scene with one key.
std::string scene_with(const KeyCase& c, const std::string& value) {
  return "[" + std::string(c.table) + "]\n" + c.key + " = " + value + "\n";
}

std::vector<std::string> lines_of(const std::string& text) {
  std::istringstream in(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

TEST(SceneConfig, EveryKeyIsReadAndChangesItsOwnOption) {
  const TempFolder folder;
  const std::vector<std::string> defaults = lines_of(to_toml(SurfaceLightFieldOptions{}));
  ASSERT_EQ(std::count_if(defaults.begin(), defaults.end(), [](const auto& l) { return l.find(" = ") != l.npos; }),
            static_cast<int>(all_keys().size()) + 1)
      << "a key without a case, or a case without its key; and the model";
  for (const KeyCase& c : all_keys()) {
    const std::string line = std::string(c.key) + " = " + c.taken;
    const auto o = load_options(folder.write("s.toml", scene_with(c, c.taken)));
    std::vector<std::string> changed = lines_of(to_toml(o)), expected = defaults;
    const auto own = std::find_if(expected.begin(), expected.end(),
                                  [&](const std::string& l) { return l.starts_with(std::string(c.key) + " = "); });
    ASSERT_NE(own, expected.end()) << c.key;
    EXPECT_NE(*own, line) << "not the default";
    *own = line;
    EXPECT_EQ(changed, expected) << c.key;
  }
}

TEST(SceneConfig, EveryKeyHasARange) {
  const TempFolder folder;
  for (const KeyCase& c : all_keys())
    for (const char* value : c.refused) {
      const auto file = folder.write("s.toml", "# a scene\n" + scene_with(c, value));
      expect_error<ConfigError>([&] { load_scene_config(file); }, {"s.toml:3: ", c.key});
    }
}

/// What comes out of a reconstruction with a scene file: counts, ranks, bytes, a picture and what is red in it.
std::string outcome(const std::vector<Capture>& images, const Mesh& mesh, const std::string& scene_text) {
  const TempFolder folder;
  const auto options = load_options(folder.write("s.toml", scene_text));
  Reconstruction built(mesh, options);
  for (const Capture& image : images) built.ingest(image);
  const PaintedView painted =
      built.painter().paint(*built.snapshot(), images[0].camera, images[0].pose.camera_from_object);
  std::string text = std::to_string(built.account().counts().accepted) + " " +
                     std::to_string(built.account().counts().held_out) + " " +
                     std::to_string(built.model().figures().bytes);
  for (const ImageF* image : {&painted.beauty, &painted.heuristic})
    text += content_hash({reinterpret_cast<const char*>(image->data()), image->size() * sizeof(float)});
  return text;
}

TEST(SceneConfig, EveryKeyChangesTheModel) {
  const Object object = square_object();
  const analytic::Scene scene{object.surface, analytic::two_terms(0.06)};
  std::vector<Capture> images = captures(scene, analytic::eyes(20, 0.5, 0.55));
  for (std::size_t i = 0; i < images.size(); ++i) {
    images[i].exposure.exposure_s = i % 2 == 0 ? 0.01 : 0.02;
    if (i % 3 != 1) continue;
    images[i].mask = ImageU8(images[i].camera.width, images[i].camera.height, 1, 255);  // half of it is hidden
    std::fill_n(images[i].mask.data(), images[i].mask.size() / 2, std::uint8_t{0});
  }
  const std::map<std::string, std::pair<std::string, std::string>> cases{
      // key: the rest of the scene, its value
      {"surface_map", {"", "7"}},
      {"map_scale", {"", "0.5"}},
      {"map_detail", {"", "0.5"}},
      {"sampling", {"", "\"linear\""}},
      {"max_rank", {"", "1"}},
      {"internal_rank", {"[surface_light_field]\nmax_rank = 2\n", "2"}},
      {"block", {"", "3"}},
      {"tolerance", {"", "0.3"}},
      {"max_views", {"", "8"}},
      {"repeat_angle", {"", "0.4"}},
      {"min_visible", {"", "1"}},
      {"hold_out_every", {"", "4"}},
      {"exposure", {"", "\"off\""}},
      {"erosion_px", {"", "6"}},
      {"interpolation", {"", "\"delaunay\""}},
      {"imputation", {"", "\"least-squares\""}},
      {"visibility", {"", "\"vertices\""}},
      {"guidance", {"", "\"paper-heuristic\""}},
  };
  ASSERT_EQ(cases.size(), all_keys().size());
  for (const KeyCase& c : all_keys()) {
    const auto& [rest, value] = cases.at(c.key);
    EXPECT_NE(outcome(images, *object.mesh, rest + scene_with(c, value)), outcome(images, *object.mesh, rest)) << c.key;
  }
}

TEST(SceneConfig, AFileThatIsNotThereIsNamed) {
  const TempFolder folder;
  expect_error([&] { load_scene_config(folder.path() / "absent.toml"); }, {"absent.toml"});
}

}  // namespace
}  // namespace sheen
