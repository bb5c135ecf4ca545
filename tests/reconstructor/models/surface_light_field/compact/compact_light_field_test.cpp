// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/compact/compact_light_field.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <mutex>
#include <random>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/image/color.h"
#include "reconstructor/light_field_file/light_field_file.h"
#include "reconstructor/models/surface_light_field/files/compact_file.h"
#include "reconstructor/models/surface_light_field/kind.h"
#include "reconstructor/models/surface_light_field/snapshot.h"
#include "tests/reconstructor/models/surface_light_field/light_field_checks.h"
#include "tests/support/expect_error.h"
#include "tests/support/temp_folder.h"

namespace sheen {
namespace {

/// Seen from one side only, so that there is something to guess.
std::vector<Eigen::Vector3d> eyes_over_half() {
  std::vector<Eigen::Vector3d> eyes;
  for (int i = 0; i < 24; ++i) {
    const double turn = 2.4 * i, lean = 0.04 * i;
    eyes.push_back(0.5 *
                   Eigen::Vector3d(std::sin(lean) * std::cos(turn), std::sin(lean) * std::sin(turn), std::cos(lean)));
  }
  return eyes;
}

class CompactLightFieldTest : public ::testing::Test {
 protected:
  CompactLightFieldTest() {
    SurfaceLightField model(object_.mesh, plain_options());
    ingest_all(model, captures(scene_, eyes_over_half()));
    exact_ = model.light_field_snapshot()->filled();
  }

  CompressedModel compressed(const CompressionTarget& target) const { return exact_->compressed(target); }
  static double psnr_db(const Appearance& model, const analytic::Scene& scene) {
    return compare(model, scene, {{0.1, 0.05, 0.48}, {-0.15, 0.1, 0.46}, {0.05, -0.2, 0.45}}).psnr_db();
  }

  /// What the model expects of its picture from one of those places.
  static double predicted_db(const Appearance& model) {
    const auto shader = model.shader_for({Eigen::Vector3d(0.1, 0.05, 0.48)});
    double square = 0, seen = 0;
    for (std::uint32_t t = 0; t < model.mesh().triangles.size(); ++t) {
      const SurfaceQuality quality = shader->quality(t);
      if (!quality.seen || model.mesh().area_normal(t).z() < 0) continue;
      square += double{quality.error} * quality.error;
      ++seen;
    }
    return -10 * std::log10(square / seen);
  }

  Object object_ = sphere_object();
  analytic::Scene scene_{object_.surface, analytic::two_terms(0.05)};
  std::shared_ptr<const ModelSnapshot> exact_;
  TempFolder temp_;
};

TEST_F(CompactLightFieldTest, ItsAverageLookIsThatOfTheModelItWasMadeOf) {
  const auto small = compressed({.loss_db = 0.1}).snapshot;
  const auto exact_look = exact_->average_look(), look = small->average_look();
  std::vector<double> off;  // grey levels
  for (std::uint32_t t = 0; t < small->mesh().triangles.size(); ++t) {
    const Eigen::Vector3f middle =
        (small->mesh().corner(t, 0) + small->mesh().corner(t, 1) + small->mesh().corner(t, 2)) / 3;
    std::uint32_t same = 0;  // triangles stand in another order
    float nearest = 1;
    for (std::uint32_t e = 0; e < exact_->mesh().triangles.size(); ++e) {
      const Mesh& mesh = exact_->mesh();
      const float away = ((mesh.corner(e, 0) + mesh.corner(e, 1) + mesh.corner(e, 2)) / 3 - middle).norm();
      if (away < nearest) same = e;
      nearest = std::min(nearest, away);
    }
    const Eigen::Vector3f a = look->shader->shade(t, 1 / 3.0f, 1 / 3.0f).rgb,
                          b = exact_look->shader->shade(same, 1 / 3.0f, 1 / 3.0f).rgb;
    for (int c = 0; c < 3; ++c) off.push_back(255 * std::abs(srgb_encode(a[c]) - srgb_encode(b[c])));
  }
  std::sort(off.begin(), off.end());
  EXPECT_LT(off[off.size() / 2], 2);
  EXPECT_LT(off[off.size() * 9 / 10], 6);
}

TEST_F(CompactLightFieldTest, LosesAsMuchAsItIsAskedTo) {
  // Photographs have noise: 36 dB. Beside the synthetic truth alone a tenth of a decibel is next to nothing.
  const auto judge = [this](const ModelSnapshot& model) {
    return -10 * std::log10(std::pow(10, -psnr_db(model, scene_) / 10) + std::pow(10, -3.6));
  };
  const double exact_db = judge(*exact_);
  double before = std::numeric_limits<double>::infinity();
  for (const double loss_db : {0.1, 0.5, 2.0}) {
    const CompressedModel small = compressed({.loss_db = loss_db, .judge = judge});
    EXPECT_LE(small.loss_db, loss_db);
    EXPECT_NEAR(exact_db - judge(*small.snapshot), small.loss_db, 1e-9);
    small.snapshot->save(temp_.path() / "small", {}, {});
    const auto bytes = static_cast<double>(std::filesystem::file_size(temp_.path() / "small"));
    EXPECT_LT(bytes, before) << "what may lose more takes less";
    before = bytes;
  }
}

TEST_F(CompactLightFieldTest, IsMadeWithoutTheModelThatItIsMadeOf) {
  const auto saved = [this](const CompressedModel& small) {
    small.snapshot->save(temp_.path() / "small", {}, {});
    return read_file(temp_.path() / "small");
  };
  const std::string expected = saved(compressed({.loss_db = 0.5}));
  const std::unique_ptr<Compression> compression = exact_->compression({.loss_db = 0.5});
  const std::weak_ptr<const ModelSnapshot> exact = exact_;
  exact_.reset();
  EXPECT_TRUE(exact.expired());
  EXPECT_EQ(saved(compression->run()), expected);
}

TEST_F(CompactLightFieldTest, KeepsToItsBytes) {
  for (const double bytes : {60e3, 30e3}) {
    const CompressedModel small = compressed({.bytes = bytes});
    small.snapshot->save(temp_.path() / "small", {}, {});
    const auto size = static_cast<double>(std::filesystem::file_size(temp_.path() / "small"));
    EXPECT_LE(size, 1.02 * bytes);
    EXPECT_GE(size, 0.98 * bytes);
  }
  EXPECT_THROW(compressed({.bytes = 500}), ConfigError);
}

TEST_F(CompactLightFieldTest, AReopenedFileIsTheSameToTheBit) {
  const CompressedModel small = compressed({.loss_db = 0.2});
  const ModelMetadata metadata{{"source", "a test"}, {"words", "\"quoted\" \xc3\xa4"}};
  const auto file = temp_.path() / "model";
  small.snapshot->save(file, metadata, {});
  const ModelKind& kind = surface_light_field_kind();
  EXPECT_TRUE(kind.reads_file(read_file_start(file, 64)));
  EXPECT_EQ(kind.file_metadata(file), metadata);
  kind.set_file_metadata(file, {{"source", "another"}});
  EXPECT_EQ(kind.file_metadata(file), (ModelMetadata{{"source", "another"}}));

  const auto opened = kind.load(file);
  EXPECT_EQ(opened->cameras().size(), exact_->cameras().size());
  EXPECT_EQ(opened->mesh().triangles, small.snapshot->mesh().triangles);
  for (const Eigen::Vector3d& eye : {Eigen::Vector3d(0.1, 0, 0.5), Eigen::Vector3d(-0.3, 0.3, 0.1)}) {
    const auto a = small.snapshot->shader_for({eye}), b = opened->shader_for({eye});
    for (std::uint32_t t = 0; t < opened->mesh().triangles.size(); t += 7) {
      EXPECT_EQ(a->shade(t, 0.3f, 0.4f).rgb, b->shade(t, 0.3f, 0.4f).rgb);
      EXPECT_EQ(a->shade(t, 0.3f, 0.4f).state, b->shade(t, 0.3f, 0.4f).state);
      EXPECT_EQ(a->quality(t).error, b->quality(t).error);
    }
  }
}

TEST_F(CompactLightFieldTest, KnowsWhatItDoesNotKnow) {
  const CompressedModel small = compressed({.loss_db = 0.2});
  const SnapshotFigures exact = exact_->figures(), figures = small.snapshot->figures();
  EXPECT_NEAR(figures.seen, exact.seen, 0.03);
  EXPECT_LT(figures.seen, 0.9) << "the far side of the sphere was shown by no image";
  EXPECT_NEAR(figures.measured, exact.measured, 0.05);
  const Eigen::Vector3d eye(0, 0, -0.5);
  const auto shader = small.snapshot->shader_for({eye}), exact_shader = exact_->shader_for({eye});
  std::size_t unseen = 0;
  double level = 0, exact_level = 0;
  for (std::uint32_t t = 0; t < small.snapshot->mesh().triangles.size(); ++t) {
    if (small.snapshot->mesh().corner(t, 0).z() > -0.08f) continue;
    const SurfaceSample sample = shader->shade(t, 0.3f, 0.3f);
    EXPECT_EQ(sample.state, SampleState::kUnseen);
    EXPECT_FALSE(shader->quality(t).seen);
    level += sample.rgb.mean();
    ++unseen;
  }
  EXPECT_GT(unseen, 10u);
  std::size_t exact_unseen = 0;
  for (std::uint32_t t = 0; t < exact_->mesh().triangles.size(); ++t) {
    if (exact_->mesh().corner(t, 0).z() > -0.08f) continue;
    exact_level += exact_shader->shade(t, 0.3f, 0.3f).rgb.mean();
    ++exact_unseen;
  }
  level /= static_cast<double>(unseen);
  exact_level /= static_cast<double>(exact_unseen);
  EXPECT_NEAR(level, exact_level, 0.2 * exact_level) << "the guess is the light field's own";
}

/// Where each chunk ends.
std::vector<std::size_t> chunk_ends(const std::string& bytes) {
  std::vector<std::size_t> ends;
  for (std::size_t at = 12; at < bytes.size();) {
    std::uint64_t size = 0;
    std::memcpy(&size, bytes.data() + at + 8, sizeof size);
    at += 16 + size;
    ends.push_back(at);
  }
  return ends;
}

TEST_F(CompactLightFieldTest, TheBeginningOfAFileIsACoarserModel) {
  const CompressedModel small = compressed({.loss_db = 0.1});
  const auto file = temp_.path() / "model";
  small.snapshot->save(file, {}, {});
  const std::string bytes = read_file(file);
  const std::vector<std::size_t> ends = chunk_ends(bytes);
  ASSERT_EQ(ends.back(), bytes.size());
  double before = 0;
  std::size_t drawn = 0;
  for (const std::size_t end : ends) {
    write_file(file, std::string_view(bytes).substr(0, end));
    try {
      const auto model = load_compact(file);
      const double db = psnr_db(*model, scene_);
      EXPECT_GT(db, before - 0.2) << "more of the file is no worse";
      EXPECT_LT(predicted_db(*model), db + 3) << "what is missing is part of what is predicted: " << end;
      before = db;
      ++drawn;
    } catch (const FileError& error) {
      EXPECT_EQ(drawn, 0u) << error.what();
      EXPECT_NE(std::string(error.what()).find("is missing: the file was cut short"), std::string::npos);
    }
  }
  EXPECT_GE(drawn, 4u);
  EXPECT_NEAR(before, psnr_db(*small.snapshot, scene_), 1e-9);
}

// A damaged file with right checksums asks for anything.
TEST_F(CompactLightFieldTest, NothingIsDrawnBrighterThanWhatImagesShowed) {
  const auto file = temp_.path() / "model";
  compressed({.loss_db = 0.5}).snapshot->save(file, {}, {});
  CompactModel model = decode_light_field(read_file(file), "model", one_after_the_other);
  EXPECT_GT(model.brightest, 100);
  EXPECT_LT(model.brightest, 300);
  for (Patch& patch : model.patches) patch.coefficients *= 1e5f;
  const float most = 1.1f * model.brightest / 255;
  const auto damaged = std::make_shared<CompactLightField>(std::move(model), nullptr);
  const auto shader = damaged->shader_for({Eigen::Vector3d(0.1, 0.05, 0.48)});
  float brightest = 0;
  for (std::uint32_t t = 0; t < damaged->mesh().triangles.size(); ++t)
    brightest = std::max(brightest, srgb_encode(shader->shade(t, 0.3f, 0.3f).rgb.maxCoeff()));
  EXPECT_NEAR(brightest, most, 1e-3f);
}

// Where images and mesh hardly agree, what an image would have shown of the rest of a patch is guessed without a bound.
TEST_F(CompactLightFieldTest, IsReadWhateverWasGuessed) {
  const auto& exact = dynamic_cast<const SurfaceLightFieldSnapshot&>(*exact_);
  SurfaceLightFieldSnapshot::Patches patches = exact.patches();
  const auto seen = std::find_if(patches.begin(), patches.end(), [](const auto& patch) { return patch->seen(); });
  ASSERT_NE(seen, patches.end());
  const auto bright = std::make_shared<PatchSnapshot>(**seen);
  for (VertexInterpolant& vertex : bright->vertices) vertex.mean *= 1e4f;
  *seen = bright;
  const auto file = temp_.path() / "model";
  exact.with_patches({patches.begin(), patches.end()})->compressed({.loss_db = 0.5}).snapshot->save(file, {}, {});
  const CompactModel model = decode_light_field(read_file(file), "model", one_after_the_other);
  EXPECT_EQ(model.brightest, CompactModel::kMostBrightest);
}

TEST_F(CompactLightFieldTest, OpensInStagesOnOneMeshUpToTheWholeModel) {
  const auto file = temp_.path() / "model";
  compressed({.loss_db = 0.1}).snapshot->save(file, {}, {});
  std::mutex mutex;
  std::vector<std::shared_ptr<const ModelSnapshot>> stages;
  surface_light_field_kind().open(file, [&](std::shared_ptr<const ModelSnapshot> model) {
    const std::lock_guard lock(mutex);
    stages.push_back(std::move(model));
  });
  ASSERT_EQ(stages.size(), 3u);
  for (const auto& stage : stages) {
    EXPECT_EQ(stage->shared_mesh(), stages.back()->shared_mesh()) << "the window frames it once";
    EXPECT_EQ(stage->cameras().size(), 24u) << "and from the first picture on as the cameras saw it";
  }
  EXPECT_TRUE(stages[0]->empty());
  EXPECT_FALSE(stages[1]->empty());
  EXPECT_EQ(stages[1]->figures().seen, stages[2]->figures().seen) << "nothing unseen is shown as seen";
  const double coarse_db = psnr_db(*stages[1], scene_), whole_db = psnr_db(*stages[2], scene_);
  EXPECT_GT(coarse_db, 15);
  EXPECT_LT(coarse_db, whole_db - 3);
  EXPECT_EQ(whole_db, psnr_db(*load_compact(file), scene_));
}

TEST_F(CompactLightFieldTest, DamageBehindTheFirstStagesStillEndsTheOpening) {
  const auto file = temp_.path() / "model";
  compressed({.loss_db = 0.5}).snapshot->save(file, {}, {});
  std::string bytes = read_file(file);
  bytes[bytes.size() - 3] ^= 0x10;
  write_file(file, bytes);
  std::atomic<int> stages = 0;
  EXPECT_THROW(surface_light_field_kind().open(file, [&](const auto&) { ++stages; }), FileError);
  EXPECT_EQ(stages, 2);
}

TEST_F(CompactLightFieldTest, DamageIsFoundByItsChunk) {
  const CompressedModel small = compressed({.loss_db = 0.5});
  const auto file = temp_.path() / "model";
  small.snapshot->save(file, {}, {});
  const std::string bytes = read_file(file);
  std::size_t begin = 12;
  for (const std::size_t end : chunk_ends(bytes)) {
    std::string damaged = bytes;
    damaged[(begin + 16 + end) / 2] ^= 0x10;
    write_file(file, damaged);
    try {
      load_compact(file);
      ADD_FAILURE() << "a flipped bit went by";
    } catch (const FileError& error) {
      const std::string what = error.what();
      EXPECT_NE(what.find("\"" + bytes.substr(begin, 4) + "\" is damaged"), std::string::npos) << what;
    }
    begin = end;
  }
  write_file(file, "sheenSLF");
  EXPECT_THROW(load_compact(file), FileError);
}

TEST(CompactCameras, MoreThanIndicesCountAreRefusedBeforeTheWork) {
  const auto mesh = std::make_shared<Mesh>();
  mesh->vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh->triangles = {{0, 1, 2}};
  const auto maps = std::make_shared<MapLayout>(std::vector<std::uint8_t>{2});
  const auto shapes = std::make_shared<const PatchShapes>(cut_into_patches(*mesh, *maps, {.triangles = 1}));
  const SurfaceLightFieldSnapshot snapshot(mesh, maps, shapes, {nullptr}, 1, {}, std::vector<PosedCamera>(65536));
  expect_error<ConfigError>([&] { snapshot.compression({}); }, {"65535 cameras", "has 65536"});
}

}  // namespace
}  // namespace sheen
