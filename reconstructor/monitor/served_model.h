// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace sheen {

/// What a desk that draws the model itself has of it, and from where it looks.
struct DeskQuestion {
  std::uint32_t scene = 0, changes = 0;  ///< numbers that it was told; 0: it has nothing
  std::array<double, 3> eye{};           ///< metres, from the mesh's origin
  bool moved = false;                    ///< it has what is seen from another eye
};

/// Empty where a text is not what its name says: two whole numbers, and x,y,z.
std::optional<DeskQuestion> desk_question(std::string_view scene, std::string_view changes, std::string_view eye,
                                          bool moved);

/// A model that desks draw themselves. Asked on the connections' thread.
class ServedModel {
 public:
  struct Answer {
    int status = 200;  ///< 404: there is no such model yet; 503: to be asked again in a moment
    std::string bytes;
  };
  virtual ~ServedModel() = default;
  virtual bool there() const = 0;
  virtual std::string_view page() const = 0;  ///< an HTML document that asks for the following
  virtual Answer scene() = 0;
  virtual Answer changes_for(const DeskQuestion& question) = 0;
};

}  // namespace sheen
