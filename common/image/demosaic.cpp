// SPDX-License-Identifier: Apache-2.0
#include "common/image/demosaic.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace sheen {
namespace {

// Where the differences say nothing, colours are taken to vary half as much as each other; the weight of that is
// against sums of squared differences of encoded values. Chosen on photographs and on the simulated rig.
constexpr float kPriorSlope = 0.5f;
constexpr float kPriorWeight = 1.2e-2f;
constexpr float kSteepest = 2;
constexpr float kFlat = 1e-3f;  // difference of encoded values below which no direction is better than another

constexpr int kReach = kDemosaicReach / 2;  // cells

/// The last rows of a plane that has a value for each cell of 2x2 sites.
class Rows {
 public:
  explicit Rows(int cells) : cells_(cells), values_(kKept * static_cast<std::size_t>(cells)) {}
  float* operator[](int row) { return values_.data() + (row & (kKept - 1)) * static_cast<std::size_t>(cells_); }

 private:
  static constexpr int kKept = 8;
  int cells_;
  std::vector<float> values_;
};

/// Products of what two colours do at each cell (differences or curvatures), `both`, and of one of them with itself,
/// `alone`.
struct Products {
  explicit Products(int cells) : both(cells), alone(cells) {}

  /// How much the first changes for a change of the other: least squares over a window of 3x3 cells.
  void slope(int j, int from, int to, float* out) {
    const float *b0 = both[j - 1], *b1 = both[j], *b2 = both[j + 1];
    const float *a0 = alone[j - 1], *a1 = alone[j], *a2 = alone[j + 1];
    for (int i = from; i < to; ++i) {
      const float sum_both =
          b0[i - 1] + b0[i] + b0[i + 1] + b1[i - 1] + b1[i] + b1[i + 1] + b2[i - 1] + b2[i] + b2[i + 1];
      const float sum_alone =
          a0[i - 1] + a0[i] + a0[i + 1] + a1[i - 1] + a1[i] + a1[i + 1] + a2[i - 1] + a2[i] + a2[i + 1];
      const float fitted = (sum_both + kPriorWeight * kPriorSlope) / (sum_alone + kPriorWeight);
      out[i] = std::min(std::max(fitted, 0.0f), kSteepest);
    }
  }

  Rows both, alone;
};

/// Red or blue, and what is found about it row by row.
struct Colour {
  /// `beside`: the green sites in its rows, `above`: those in its columns; the first of each pair of neighbours is
  /// `before` cells on.
  Colour(int cells, Rows& beside, Rows& above, int before)
      : site(cells),
        green(cells),
        offset(cells),
        slope(cells),
        beside(beside),
        above(above),
        before(before),
        on_colour(cells),
        on_green(cells),
        green_slope(cells) {}

  /// Of the differences to the four neighbours. Those of green are between means of the sites on both sides, across the
  /// direction of the difference, since along it a mean would blur.
  void compare_differences(int j, int from, int to) {
    const float *up = site[j - 1], *here = site[j], *down = site[j + 1];
    const float *top = above[j + before], *bottom = above[j + before + 1];
    const float *up_left = beside[j - 1] + before, *left = beside[j] + before, *down_left = beside[j + 1] + before;
    float *both = on_colour.both[j], *alone = on_colour.alone[j];
    for (int i = from; i < to; ++i) {
      const float to_left = here[i - 1] - here[i], to_right = here[i + 1] - here[i];
      const float to_up = up[i] - here[i], to_down = down[i] - here[i];
      const float green_in_column = top[i] + bottom[i], green_in_row = left[i] + left[i + 1];
      both[i] = 0.5f * (to_left * (top[i - 1] + bottom[i - 1] - green_in_column) +
                        to_right * (top[i + 1] + bottom[i + 1] - green_in_column) +
                        to_up * (up_left[i] + up_left[i + 1] - green_in_row) +
                        to_down * (down_left[i] + down_left[i + 1] - green_in_row));
    }
    for (int i = from; i < to; ++i) {  // on its own: loops with two results are not vectorised
      const float to_left = here[i - 1] - here[i], to_right = here[i + 1] - here[i];
      const float to_up = up[i] - here[i], to_down = down[i] - here[i];
      alone[i] = to_left * to_left + to_right * to_right + to_up * to_up + to_down * to_down;
    }
  }

  /// Green at the colour's sites: the mean of those on both sides, corrected by the curvature of the colour, in the
  /// direction that varies less (Hamilton and Adams 1997, with fitted slopes).
  void find_green(int j, int from, int to) {
    on_colour.slope(j, from, to, green_slope.data());
    const float *up = site[j - 1], *here = site[j], *down = site[j + 1];
    const float *left = beside[j] + before, *top = above[j + before], *bottom = above[j + before + 1];
    float* out = green[j];
    for (int i = from; i < to; ++i) {
      const float row_curvature = green_slope[i] * (2 * here[i] - here[i - 1] - here[i + 1]);
      const float column_curvature = green_slope[i] * (2 * here[i] - up[i] - down[i]);
      const float row_change = std::abs(left[i] - left[i + 1]) + std::abs(row_curvature) + kFlat;
      const float column_change = std::abs(top[i] - bottom[i]) + std::abs(column_curvature) + kFlat;
      const float row_weight = column_change * column_change, column_weight = row_change * row_change;
      out[i] = (row_weight * (0.5f * (left[i] + left[i + 1]) + 0.25f * row_curvature) +
                column_weight * (0.5f * (top[i] + bottom[i]) + 0.25f * column_curvature)) /
               (row_weight + column_weight);
    }
  }

  /// Of curvatures, now that green is known at the colour's own sites: it is the fine detail that is to be predicted.
  void compare_curvatures(int j, int from, int to) {
    const float *up = site[j - 1], *here = site[j], *down = site[j + 1];
    const float *green_up = green[j - 1], *green_here = green[j], *green_down = green[j + 1];
    float *both = on_green.both[j], *alone = on_green.alone[j];
    for (int i = from; i < to; ++i) {
      const float colour = 4 * here[i] - here[i - 1] - here[i + 1] - up[i] - down[i];
      const float guide = 4 * green_here[i] - green_here[i - 1] - green_here[i + 1] - green_up[i] - green_down[i];
      both[i] = 0.25f * guide * colour;
    }
    for (int i = from; i < to; ++i) {
      const float guide = 4 * green_here[i] - green_here[i - 1] - green_here[i + 1] - green_up[i] - green_down[i];
      alone[i] = 0.25f * guide * guide;
    }
  }

  /// The colour round each of its sites is offset + slope * green.
  void fit(int j, int from, int to) {
    float *slopes = slope[j], *offsets = offset[j];
    on_green.slope(j, from, to, slopes);
    const float *own = site[j], *greens = green[j];
    for (int i = from; i < to; ++i) offsets[i] = own[i] - slopes[i] * greens[i];
  }

  Rows site, green, offset, slope;
  Rows &beside, &above;
  int before;
  Products on_colour, on_green;
  std::vector<float> green_slope;
};

/// A colour at a site of another: the mean of what the four fits round it say (two or each twice, on a line with them).
struct Between {
  const float *offset[4], *slope[4];
  float at(int i, float green) const {
    return 0.25f * (offset[0][i] + offset[1][i] + offset[2][i] + offset[3][i] +
                    (slope[0][i] + slope[1][i] + slope[2][i] + slope[3][i]) * green);
  }
};
Between between(Colour& c, int j0, int j1, int di0, int di1) {
  return {{c.offset[j0] + di0, c.offset[j0] + di1, c.offset[j1] + di0, c.offset[j1] + di1},
          {c.slope[j0] + di0, c.slope[j0] + di1, c.slope[j1] + di0, c.slope[j1] + di1}};
}

}  // namespace

float root_encode(float linear) {
  return std::sqrt(linear + kRootAtBlack * kRootAtBlack) - kRootAtBlack;
}

void demosaic(int width, int height, const std::function<void(int y, std::span<float> sites)>& load,
              const std::function<void(int y, const float* red, const float* green, const float* blue)>& take) {
  const int cells = width / 2 + 2 * kReach, rows = height / 2;
  Rows green_of_red_row(cells), green_of_blue_row(cells);
  Colour red(cells, green_of_red_row, green_of_blue_row, -1), blue(cells, green_of_blue_row, green_of_red_row, 0);
  std::vector<float> sites(2 * static_cast<std::size_t>(cells)), pixels(3 * static_cast<std::size_t>(width));

  const auto split = [&](int y, float* even, float* odd) {
    load(y, sites);
    for (int i = 0; i < cells; ++i) {
      even[i] = sites[2 * i];
      odd[i] = sites[2 * i + 1];
    }
  };
  const auto emit = [&](int y, const auto& even_rgb, const auto& odd_rgb) {
    float *r = pixels.data(), *g = r + width, *b = g + width;
    for (int i = 0; i < width / 2; ++i) {
      even_rgb(i + kReach, r[2 * i], g[2 * i], b[2 * i]);
      odd_rgb(i + kReach, r[2 * i + 1], g[2 * i + 1], b[2 * i + 1]);
    }
    take(y, r, g, b);
  };

  // Each step looks at the rows beside its own, so it follows the one before it a row behind.
  for (int j = -kReach; j < rows + kReach; ++j) {
    split(2 * j, red.site[j], green_of_red_row[j]);
    split(2 * j + 1, green_of_blue_row[j], blue.site[j]);
    for (Colour* c : {&red, &blue}) {
      if (j - 1 >= 1 - kReach) c->compare_differences(j - 1, 1, cells - 1);
      if (j - 2 >= 2 - kReach) c->find_green(j - 2, 2, cells - 2);
      if (j - 3 >= 3 - kReach) c->compare_curvatures(j - 3, 3, cells - 3);
      if (j - 4 >= 4 - kReach) c->fit(j - 4, 4, cells - 4);
    }
    const int k = j - 5;
    if (k < 0 || k >= rows) continue;
    // Of a cell's sites, 00 is red, 10 the green right of it, 01 the green below, 11 blue.
    const Between r10 = between(red, k, k, 0, 1), r01 = between(red, k, k + 1, 0, 0),
                  r11 = between(red, k, k + 1, 0, 1);
    const Between b10 = between(blue, k - 1, k, 0, 0), b01 = between(blue, k, k, -1, 0),
                  b00 = between(blue, k - 1, k, -1, 0);
    const float *r00 = red.site[k], *b11 = blue.site[k], *g00 = red.green[k], *g11 = blue.green[k];
    const float *g10 = green_of_red_row[k], *g01 = green_of_blue_row[k];
    emit(
        2 * k, [=](int i, float& r, float& g, float& b) { r = r00[i], g = g00[i], b = b00.at(i, g00[i]); },
        [=](int i, float& r, float& g, float& b) { r = r10.at(i, g10[i]), g = g10[i], b = b10.at(i, g10[i]); });
    emit(
        2 * k + 1,
        [=](int i, float& r, float& g, float& b) { r = r01.at(i, g01[i]), g = g01[i], b = b01.at(i, g01[i]); },
        [=](int i, float& r, float& g, float& b) { r = r11.at(i, g11[i]), g = g11[i], b = b11[i]; });
  }
}

}  // namespace sheen
