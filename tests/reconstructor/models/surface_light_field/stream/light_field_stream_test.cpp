// SPDX-License-Identifier: Apache-2.0
// A desk that reads the stream as its description says, and puts colours together as the page's shader does.
#include "reconstructor/models/surface_light_field/stream/light_field_stream.h"

#include <gtest/gtest.h>

#include <cstring>
#include <map>

#include "common/image/color.h"
#include "tests/reconstructor/models/surface_light_field/light_field_checks.h"

namespace sheen {
namespace {

constexpr std::uint32_t kNothingKnown = UINT32_MAX;

/// Numbers out of bytes, one table behind the other.
class Tables {
 public:
  explicit Tables(const std::string& bytes) : bytes_(bytes) {}
  template <typename Number>
  std::vector<Number> next(std::size_t count) {
    std::vector<Number> numbers(count);
    const std::string part = bytes_.substr(at_, count * sizeof(Number));
    EXPECT_EQ(part.size(), count * sizeof(Number)) << "the answer is too short";
    std::memcpy(numbers.data(), part.data(), part.size());
    at_ += part.size();
    return numbers;
  }
  bool at_end() const { return at_ == bytes_.size(); }

 private:
  std::string bytes_;
  std::size_t at_ = 0;
};

class Desk {
 public:
  explicit Desk(LightFieldStream& stream) : stream_(stream) {}

  void look_from(const Eigen::Vector3d& eye) {
    state_.eye = eye;
    state_.moved = true;
  }
  /// Asks until there is nothing more; returns how often it had to.
  int catch_up() {
    for (int asked = 1;; ++asked) {
      const std::string answer = stream_.changes_for(state_);
      Tables tables(answer);
      const auto head = tables.next<std::uint32_t>(9);
      EXPECT_EQ(head[0], 2u);
      if (head[1] != state_.scene) {
        enter();
        continue;
      }
      EXPECT_TRUE(asked == 1 || head[4] > 0) << "an answer with nothing in it";
      state_.changes = head[2];
      waited_ms_ = head[8];
      if (head[5]) read_seen(tables);
      EXPECT_EQ(head[5], state_.moved && !head[3] ? 1u : 0u) << "changes first";
      if (head[5]) state_.moved = false;
      for (std::uint32_t i = 0; i < head[4]; ++i) read_patch(tables);
      cameras_ = tables.next<float>(14 * std::size_t{head[6]}).size() / 14;
      EXPECT_TRUE(tables.at_end());
      if (head[3] == 0) return asked;
    }
  }
  bool known(std::size_t triangle) const { return patches_.at(places_[triangle][0]).terms != kNothingKnown; }
  /// Encoded, of a sample of a triangle.
  Eigen::Vector3f colour(std::size_t triangle, std::size_t sample, const Eigen::Vector3f& beta) const {
    const auto& place = places_[triangle];
    const Patch& patch = patches_.at(place[0]);
    const std::size_t at = place[1] + sample;
    Eigen::Vector3f colour;
    for (std::size_t c = 0; c < 3; ++c)
      colour[static_cast<Eigen::Index>(c)] =
          patch.low + patch.width * static_cast<float>(patch.means[4 * at + c]) / 255;
    for (std::size_t r = 0; r < patch.terms; ++r) {
      float amount = 0;
      for (std::size_t k = 0; k < 3; ++k)
        amount += beta[static_cast<Eigen::Index>(k)] *
                  (patch.coefficients[(place[3 + k] - patch.column) * patch.terms + r] - patch.mean[r]);
      for (std::size_t c = 0; c < 3; ++c)
        colour[static_cast<Eigen::Index>(c)] +=
            amount * patch.amounts[r] * (static_cast<float>(patch.texels[4 * (at * patch.terms + r) + c]) - 128) / 255;
    }
    return colour;
  }
  int state(std::size_t triangle, std::size_t sample) const {
    return patches_.at(places_[triangle][0]).means[4 * (places_[triangle][1] + sample) + 3] / 127;
  }
  /// It shows its means: nobody has found what else it looks like.
  bool shows_means(std::size_t triangle) const {
    const Patch& patch = patches_.at(places_[triangle][0]);
    for (std::size_t i = 0; i < patch.coefficients.size(); ++i)
      if (patch.coefficients[i] != patch.mean[i % patch.terms]) return false;
    return true;
  }
  std::size_t cameras() const { return cameras_; }
  std::uint32_t waited_ms() const { return waited_ms_; }  ///< that it was told last
  int scenes() const { return scenes_; }

 private:
  struct Patch {
    std::size_t samples = 0, column = 0, columns = 0;
    std::uint32_t terms = kNothingKnown;
    float low = 0, width = 0;
    std::vector<float> mean, amounts, coefficients;
    std::vector<std::uint8_t> means, texels;
  };

  void enter() {
    const std::string scene = stream_.scene();
    Tables tables(scene);
    const auto head = tables.next<std::uint32_t>(8);
    state_.scene = head[1];
    state_.changes = 0;
    tables.next<double>(14);
    tables.next<float>(3 * std::size_t{head[2]});
    tables.next<std::uint32_t>(3 * std::size_t{head[3]});
    tables.next<std::uint32_t>(head[7]);
    places_.clear();
    for (std::uint32_t t = 0; t < head[3]; ++t) places_.push_back(tables.next<std::uint32_t>(6));
    const auto patches = tables.next<std::uint32_t>(2 * std::size_t{head[4]});
    EXPECT_TRUE(tables.at_end());
    patches_.assign(head[4], {});
    for (std::size_t p = 0; p < patches_.size(); ++p) {
      patches_[p].samples = patches[2 * p];
      patches_[p].column = patches[2 * p + 1];
      patches_[p].columns = (p + 1 < patches_.size() ? patches[2 * p + 3] : head[5]) - patches[2 * p + 1];
    }
    ++scenes_;
  }
  void read_seen(Tables& tables) {
    const auto held = tables.next<std::uint32_t>((patches_.size() + 31) / 32);
    for (std::size_t p = 0; p < patches_.size(); ++p)
      if (held[p / 32] >> (p % 32) & 1)
        patches_[p].coefficients = tables.next<float>(patches_[p].columns * patches_[p].terms);
  }
  void read_patch(Tables& tables) {
    const auto head = tables.next<std::uint32_t>(2);
    Patch& patch = patches_.at(head[0]);
    patch.terms = head[1];
    const auto range = tables.next<float>(2);
    patch.low = range[0];
    patch.width = range[1];
    const std::size_t terms = patch.terms == kNothingKnown ? 0 : patch.terms;
    patch.mean = tables.next<float>(terms);
    patch.amounts = tables.next<float>(terms);
    patch.coefficients = tables.next<float>(patch.columns * terms);
    patch.means = tables.next<std::uint8_t>(4 * patch.samples);
    patch.texels = tables.next<std::uint8_t>(4 * patch.samples * terms);
  }

  LightFieldStream& stream_;
  DeskState state_;
  std::vector<std::vector<std::uint32_t>> places_;
  std::vector<Patch> patches_;
  std::size_t cameras_ = 0;
  std::uint32_t waited_ms_ = 0;
  int scenes_ = 0;
};

class LightFieldStreamTest : public ::testing::Test {
 protected:
  std::shared_ptr<const SurfaceLightFieldSnapshot> grown(const std::vector<Eigen::Vector3d>& eyes) {
    ingest_all(model_, captures(scene_, eyes));
    return model_.light_field_snapshot();
  }
  /// What the desk shows from an eye is what the model shows, to the rounding of eight bits a term.
  static void expect_shown(const Desk& desk, const SurfaceLightFieldSnapshot& snapshot, const Eigen::Vector3d& eye) {
    const auto shader = snapshot.shader_for({eye});
    std::size_t known = 0;
    float most = 0;
    for (std::uint32_t t = 0; t < snapshot.mesh().triangles.size(); ++t) {
      const auto patch = snapshot.patch(snapshot.place(t).patch);
      ASSERT_EQ(desk.known(t), patch && patch->rank() > 0) << "triangle " << t;
      const Eigen::Vector3f to_eye = (eye.cast<float>() - snapshot.mesh().corner(t, 1)).normalized();
      if (!desk.known(t) || snapshot.mesh().area_normal(t).normalized().dot(to_eye) < 0.1f) continue;
      ++known;
      // Its second corner is a sample of its own.
      const LatticeStencil corner = lattice_stencil(snapshot.maps().resolution(t), 1, 0);
      const int at = corner.weight[0] > 0.5f ? 0 : corner.weight[1] > 0.5f ? 1 : 2;
      const SurfaceSample truth = shader->shade(t, 1, 0);
      const Eigen::Vector3f shown = desk.colour(t, static_cast<std::size_t>(corner.index[at]), {0, 1, 0});
      ASSERT_EQ(desk.state(t, static_cast<std::size_t>(corner.index[at])), static_cast<int>(truth.state));
      for (int c = 0; c < 3; ++c) most = std::max(most, 255 * std::abs(shown[c] - srgb_encode(truth.rgb[c])));
    }
    EXPECT_GT(known, 50u);
    EXPECT_LT(most, 2.0f);
  }

  Object object_ = sphere_object();
  analytic::Scene scene_{object_.surface, analytic::two_terms(0.05)};
  SurfaceLightField model_{object_.mesh, plain_options()};
  LightFieldStream stream_{20'000};
};

TEST_F(LightFieldStreamTest, ADeskShowsWhatTheModelShows) {
  stream_.follow(grown(analytic::eyes(3, 0.5, 0.8)), std::chrono::steady_clock::now());
  Desk desk(stream_);
  const Eigen::Vector3d eye(0.2, 0.1, 0.4), other(-0.3, 0.2, 0.2);
  desk.look_from(eye);
  EXPECT_GT(desk.catch_up(), 3) << "small answers";
  expect_shown(desk, *model_.light_field_snapshot(), eye);
  EXPECT_EQ(desk.cameras(), 3u);
  desk.look_from(other);
  EXPECT_EQ(desk.catch_up(), 1) << "coefficients alone";
  expect_shown(desk, *model_.light_field_snapshot(), other);

  const auto more = grown(analytic::eyes(20, 0.5, -0.8));
  stream_.follow(more, std::chrono::steady_clock::now());
  desk.catch_up();
  expect_shown(desk, *more, other);
  EXPECT_EQ(desk.cameras(), 23u);
  EXPECT_EQ(desk.catch_up(), 1);
}

TEST_F(LightFieldStreamTest, ADeskThatMovesWhileTheModelGrowsMixesNothing) {
  stream_.follow(grown(analytic::eyes(12, 0.5, -0.8)), std::chrono::steady_clock::now());
  Desk desk(stream_), late(stream_);
  desk.look_from({0.2, 0.1, 0.4});
  desk.catch_up();
  const auto more = grown(analytic::eyes(9, 0.4, 0.2));
  stream_.follow(more, std::chrono::steady_clock::now());
  const Eigen::Vector3d eye(0.35, -0.1, 0.3);
  desk.look_from(eye);  // told together with the last of many changes
  desk.catch_up();
  expect_shown(desk, *more, eye);
  late.look_from(eye);
  late.catch_up();
  expect_shown(late, *more, eye);
}

TEST_F(LightFieldStreamTest, WhatFacesAwayIsShownByItsMeansUntilItIsTurnedTo) {
  const auto snapshot = grown(analytic::eyes(12, 0.5, 0.8));
  stream_.follow(snapshot, std::chrono::steady_clock::now());
  Desk desk(stream_);
  const Eigen::Vector3d above(0.1, 0.1, 0.45), beside(0.4, 0.1, 0.1);
  desk.look_from(above);
  desk.catch_up();
  const Eigen::MatrixXf from_above = snapshot->coefficients_for(above),
                        from_beside = snapshot->coefficients_for(beside);
  std::vector<std::size_t> away, turned_to;
  for (std::size_t t = 0; t < snapshot->mesh().triangles.size(); ++t) {
    const auto cosine = [&](const Eigen::Vector3d& eye) {
      const Eigen::Vector3f to_eye = (eye.cast<float>() - snapshot->mesh().corner(t, 0)).normalized();
      return snapshot->mesh().area_normal(t).normalized().dot(to_eye);
    };
    const std::uint32_t column = snapshot->place(t).columns[0];
    const bool varies = from_above.col(column) != from_beside.col(column);
    if (!desk.known(t) || !varies || !desk.shows_means(t)) continue;
    away.push_back(t);
    EXPECT_LT(cosine(above), 0) << "triangle " << t;
    if (cosine(beside) > 0.1f) turned_to.push_back(t);
  }
  EXPECT_GT(away.size(), 20u);
  ASSERT_GT(turned_to.size(), 5u);
  desk.look_from(beside);
  EXPECT_EQ(desk.catch_up(), 1);
  for (const std::size_t t : turned_to) EXPECT_FALSE(desk.shows_means(t)) << "triangle " << t;
  expect_shown(desk, *snapshot, beside);
}

TEST_F(LightFieldStreamTest, ADeskIsToldHowLongItsOldestChangeHasWaited) {
  const auto now = std::chrono::steady_clock::now();
  stream_.follow(grown(analytic::eyes(3, 0.5, 0.8)), now - std::chrono::hours(3));
  Desk desk(stream_);
  desk.catch_up();
  EXPECT_GE(desk.waited_ms(), 3 * 3'600'000u);
  stream_.follow(grown(analytic::eyes(3, 0.5, -0.8)), now - std::chrono::hours(1));
  desk.catch_up();
  EXPECT_GE(desk.waited_ms(), 3'600'000u);
  EXPECT_LT(desk.waited_ms(), 2 * 3'600'000u);
}

TEST_F(LightFieldStreamTest, WhatIsTakenBackIsGoneFromTheDesk) {
  const Eigen::Vector3d eye(0.1, 0.1, 0.45);
  const std::vector<Capture> first = captures(scene_, analytic::eyes(6, 0.5, 0.8)),
                             below = captures(scene_, {{0, 0, -0.5}});
  ingest_all(model_, first);
  stream_.follow(model_.light_field_snapshot(), std::chrono::steady_clock::now());
  Desk desk(stream_);
  desk.look_from(eye);
  desk.catch_up();
  SurfaceLightField again(object_.mesh, plain_options());  // the same maps are not the same object: another scene
  ingest_all(again, below);
  stream_.follow(again.light_field_snapshot(), std::chrono::steady_clock::now());
  const Eigen::Vector3d from_below(0.1, 0.1, -0.45);
  desk.look_from(from_below);
  desk.catch_up();
  expect_shown(desk, *again.light_field_snapshot(), from_below);
  desk.look_from(eye);
  stream_.follow(model_.light_field_snapshot(), std::chrono::steady_clock::now());
  desk.catch_up();
  expect_shown(desk, *model_.light_field_snapshot(), eye);
  EXPECT_EQ(desk.scenes(), 3);
}

TEST_F(LightFieldStreamTest, ADeskOfAnotherProgramIsToldOfThisOnesScene) {
  stream_.follow(grown(analytic::eyes(3, 0.5, 0.8)), std::chrono::steady_clock::now());
  const std::string answer = stream_.changes_for({.scene = 77, .changes = 5'000'000});
  EXPECT_EQ(answer.size(), 36u);
  LightFieldStream another;
  another.follow(model_.light_field_snapshot(), std::chrono::steady_clock::now());
  EXPECT_NE(another.scene().substr(4, 4), stream_.scene().substr(4, 4));
}

}  // namespace
}  // namespace sheen
