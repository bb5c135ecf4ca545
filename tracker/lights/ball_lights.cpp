// SPDX-License-Identifier: Apache-2.0
#include "tracker/lights/ball_lights.h"

#include <algorithm>

#include "common/base/errors.h"
#include "common/base/format.h"
#include "tracker/lights/circle_search.h"

namespace sheen {
namespace {

constexpr std::size_t kMostCircles = 10, kMostBalls = 4;
constexpr const char* kSayWhere = "; say where it is: --ball X,Y,RADIUS in pixels";

std::string text_of(const BallCircle& circle) {
  return format("x %.0f, y %.0f, radius %.0f", circle.centre.x(), circle.centre.y(), circle.radius);
}

/// A ball, with the lights that it shows.
struct Candidate {
  HighlightFinder finder;
  BallLights lights;
};

}  // namespace

std::size_t BallLights::found() const {
  return static_cast<std::size_t>(
      std::count_if(images.begin(), images.end(), [](const auto& answer) { return answer.highlight.has_value(); }));
}

BallLights lights_of_ball(const BallView& view, std::size_t images, const std::function<ImageF(std::size_t)>& read,
                          const std::optional<BallCircle>& about, const StepsDone& done) {
  const std::size_t passes = about ? 2 : 3;
  std::size_t steps = 0;
  const auto for_each_picture = [&](const auto& see) {
    for (std::size_t i = 0; i < images; ++i) {
      see(view.straighten(read(i)));
      if (done) done(++steps, passes * images);
    }
  };

  std::vector<BallCircle> circles;
  if (about) {
    circles.push_back(view.straightened(*about));
  } else {
    CircleSearch search;
    for_each_picture([&](const ImageF& picture) { search.add(picture); });
    circles = search.circles(kMostCircles);
  }
  std::vector<BallEvidence> evidence;
  for (const BallCircle& circle : circles) {
    evidence.emplace_back(view, circle);
    if (evidence.back().crop().empty()) evidence.pop_back();
  }
  for_each_picture([&](const ImageF& picture) {
    for (BallEvidence& place : evidence) place.add(picture);
  });
  std::vector<Candidate> balls;
  for (const BallEvidence& place : evidence) {
    if (balls.size() == kMostBalls) break;
    if (const auto outline = place.outline())
      balls.push_back({HighlightFinder(view, *outline, place.crop(), place.background()), {.outline = *outline}});
  }
  if (balls.empty())
    throw Error(about ? "the images show no ball at " + text_of(*about) +
                            ": no circle's edge is within a third of the radius"
                      : std::string("no ball was found: no outline in the images is a circle") + kSayWhere);

  for_each_picture([&](const ImageF& picture) {
    for (Candidate& ball : balls) ball.lights.images.push_back(ball.finder.find(picture));
  });
  const std::size_t least = about ? 1 : (2 * images + 2) / 3;  // a person who says where it is knows
  const Candidate* best = nullptr;
  for (const Candidate& ball : balls) {  // what it mirrors may look like circles inside of it, but not all round
    if (ball.lights.found() < least) continue;
    if (!best || ball.lights.outline.support > best->lights.outline.support) best = &ball;
  }
  if (!best) {
    const Candidate& nearest = *std::max_element(
        balls.begin(), balls.end(), [](const auto& a, const auto& b) { return a.lights.found() < b.lights.found(); });
    throw Error("no ball was found: the circle at " + text_of(view.in_image(nearest.lights.outline.circle)) +
                format(" shows a highlight in %zu of %zu images", nearest.lights.found(), images) +
                (about ? "" : kSayWhere));
  }
  return best->lights;
}

}  // namespace sheen
