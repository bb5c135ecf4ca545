// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace sheen {

/// A surface light field (.slf): a triangle mesh, and how it looks from any eye. It draws nothing itself: ask, for each
/// point of the surface that your rays or your rasteriser meet, for its colour.
///
///     const sheen::LightField object("object.slf");
///     const sheen::LightField::View view = object.from({0.4, 0.1, 0.3});
///     const sheen::LightField::Colour colour = view.shade(triangle, u, v);
///
/// Nothing changes after the constructor: all may be called from several threads at once. Moved from, an object can
/// only be assigned to and destroyed.
class __attribute__((visibility("default"))) LightField {
 public:
  using Point = std::array<double, 3>;            ///< metres, in the frame of the mesh that the model was built on
  using Triangle = std::array<std::uint32_t, 3>;  ///< vertices, counter-clockwise seen from outside
  using Colour = std::array<float, 3>;            ///< linear radiance: red, green, blue of sRGB's primaries

  /// How the surface looks from one eye. It needs no `LightField` to live on.
  class __attribute__((visibility("default"))) View {
   public:
    View(View&&) noexcept;
    View& operator=(View&&) noexcept;
    ~View();

    /// Of the front of `triangle` at (1 - u - v) a + u b + v c of its corners a, b, c. Black where nothing is known.
    /// Backs have no colour: images showed none. Throws std::out_of_range.
    Colour shade(std::uint32_t triangle, float u, float v) const;

   private:
    friend class LightField;
    struct State;
    explicit View(std::unique_ptr<const State> state);
    std::unique_ptr<const State> state_;
  };

  /// Opens a file. Throws std::runtime_error that names it, and what is wrong with it.
  explicit LightField(const std::string& path);
  LightField(LightField&&) noexcept;
  LightField& operator=(LightField&&) noexcept;
  ~LightField();

  const std::vector<Point>& vertices() const;
  const std::vector<Triangle>& triangles() const;
  /// From where the images were taken that it was built from.
  const std::vector<Point>& eyes() const;

  /// Some milliseconds: make it once for a picture.
  View from(const Point& eye) const;

 private:
  struct Content;
  std::shared_ptr<const Content> content_;
};

}  // namespace sheen
