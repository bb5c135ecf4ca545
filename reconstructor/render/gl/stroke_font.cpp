// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/render/gl/stroke_font.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <string_view>
#include <vector>

namespace sheen {
namespace {

/// Strokes of each glyph from ' ' on: pairs of digits x y on a grid, x 0..4 to the right, y 0..6 from a capital's top
/// to the base line, 8 the foot of descenders. A space ends a stroke; a stroke of one point is a dot.
constexpr const char* kGlyphs[] = {
    "",                                  // space
    "2024 26",                           // !
    "1012 3032",                         // "
    "1016 3036 0242 0444",               // #
    "413010010213334445361605 2026",     // $
    "0640 0001111000 3536464535",        // %
    "4612112031320405162644",            // &
    "2022",                              // '
    "30121436",                          // (
    "10323416",                          // )
    "2125 0244 0442",                    // *
    "2125 0343",                         // +
    "252617",                            // ,
    "0343",                              // -
    "26",                                // .
    "0640",                              // /
    "103041453616050110 1432",           // 0
    "112026 1636",                       // 1
    "01103041420646",                    // 2
    "0110304142334445361605 1333",       // 3
    "36300444",                          // 4
    "400002324345361605",                // 5
    "4130100105163645443303",            // 6
    "004016",                            // 7
    "13020110304142331304051636454433",  // 8
    "0516364541301001021343",            // 9
    "23 26",                             // :
    "23 2617",                           // ;
    "410345",                            // <
    "0242 0444",                         // =
    "014305",                            // >
    "01103041422324 26",                 // ?
    "361605011030414434322213142434",    // @
    "0602204246 0444",                   // A
    "00063645443303 3342413000",         // B
    "4130100105163645",                  // C
    "00062644422000",                    // D
    "40000646 0333",                     // E
    "400006 0333",                       // F
    "41301001051636454323",              // G
    "0006 4046 0343",                    // H
    "1030 2026 1636",                    // I
    "4045361605",                        // J
    "0006 400346",                       // K
    "000646",                            // L
    "0600234046",                        // M
    "06004640",                          // N
    "103041453616050110",                // O
    "06003041423303",                    // P
    "103041453616050110 2446",           // Q
    "06003041423303 2346",               // R
    "413010010213334445361605",          // S
    "0040 2026",                         // T
    "000516364540",                      // U
    "002640",                            // V
    "0016233640",                        // W
    "0046 4006",                         // X
    "002340 2326",                       // Y
    "00400646",                          // Z
    "30101636",                          // [
    "0046",                              // backslash
    "10303616",                          // ]
    "022042",                            // ^
    "0747",                              // _
    "1021",                              // `
    "12324346 441405163645",             // a
    "0006 0312324345361605",             // b
    "4332120305163645",                  // c
    "4046 4332120305163645",             // d
    "04444332120305163645",              // e
    "40302126 1232",                     // f
    "42473818 4332120305163645",         // g
    "0006 0312324346",                   // h
    "20 122226 1636",                    // i
    "30 2232372818",                     // j
    "0006 0442 2346",                    // k
    "102026 1636",                       // l
    "0206 03122326 23324346",            // m
    "0206 0312324346",                   // n
    "123243453616050312",                // o
    "0208 0312324345361605",             // p
    "4248 4332120305163645",             // q
    "0206 042242",                       // r
    "43321203143445361605",              // s
    "10152636 0232",                     // t
    "0205163645 4246",                   // u
    "022642",                            // v
    "0216243642",                        // w
    "0246 4206",                         // x
    "0205163645 42473818",               // y
    "02420646",                          // z
    "30212213242536",                    // {
    "2027",                              // |
    "10212233242516",                    // }
    "03123443",                          // ~
};
static_assert(std::size(kGlyphs) == GlyphAtlas::kLast - GlyphAtlas::kFirst + 1);

constexpr float kCellWidth = 6, kCellHeight = 10.5f, kLeft = 1, kTop = 1.25f;  // in grid units

using Stroke = std::vector<Eigen::Vector2f>;

std::vector<Stroke> strokes_of(std::string_view glyph) {
  std::vector<Stroke> strokes(1);
  for (std::size_t i = 0; i < glyph.size();) {
    if (glyph[i] == ' ') {
      strokes.emplace_back();
      ++i;
      continue;
    }
    strokes.back().emplace_back(glyph[i] - '0', glyph[i + 1] - '0');
    i += 2;
  }
  return strokes;
}

float distance_to_segment(const Eigen::Vector2f& p, const Eigen::Vector2f& a, const Eigen::Vector2f& b) {
  const Eigen::Vector2f ab = b - a;
  const float length2 = ab.squaredNorm();
  const float t = length2 > 0 ? std::clamp((p - a).dot(ab) / length2, 0.0f, 1.0f) : 0.0f;
  return (p - a - t * ab).norm();
}

float distance_to_strokes(const Eigen::Vector2f& p, const std::vector<Stroke>& strokes) {
  float nearest = 1e9f;
  for (const Stroke& s : strokes)
    for (std::size_t i = 0; i < s.size(); ++i)
      nearest = std::min(nearest, distance_to_segment(p, s[i], s[std::min(i + 1, s.size() - 1)]));
  return nearest;
}

}  // namespace

GlyphAtlas draw_glyphs(float unit) {
  constexpr int kCount = GlyphAtlas::kLast - GlyphAtlas::kFirst + 1;
  constexpr int kRows = (kCount + GlyphAtlas::kColumns - 1) / GlyphAtlas::kColumns;
  GlyphAtlas atlas;
  atlas.cell_width = static_cast<int>(std::lround(kCellWidth * unit));
  atlas.cell_height = static_cast<int>(std::lround(kCellHeight * unit));
  atlas.coverage = ImageU8(atlas.cell_width * GlyphAtlas::kColumns, atlas.cell_height * kRows, 1);
  const float half_width = std::max(0.62f, 0.42f * unit);  // pixels
  for (int g = 0; g < kCount; ++g) {
    const std::vector<Stroke> strokes = strokes_of(kGlyphs[g]);
    const int left = g % GlyphAtlas::kColumns * atlas.cell_width, top = g / GlyphAtlas::kColumns * atlas.cell_height;
    for (int y = 0; y < atlas.cell_height; ++y)
      for (int x = 0; x < atlas.cell_width; ++x) {
        const Eigen::Vector2f grid((x + 0.5f) / unit - kLeft, (y + 0.5f) / unit - kTop);
        const float inside = half_width + 0.5f - unit * distance_to_strokes(grid, strokes);
        atlas.coverage.at(left + x, top + y) = static_cast<std::uint8_t>(255 * std::clamp(inside, 0.0f, 1.0f));
      }
  }
  return atlas;
}

}  // namespace sheen
