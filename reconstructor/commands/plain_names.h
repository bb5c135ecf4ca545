// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <set>
#include <string>

namespace sheen {

/// Names of files that every program takes, made of names that need not be any. Slashes part folders.
class PlainNames {
 public:
  /// The name without its first folder `images` and without the extension of an image. What a shell, a list with spaces
  /// between or another system's disk does not take becomes `_`; no name leads out of its folder, is longer than a disk
  /// allows, or is that of another one, in upper or lower case, or of its folder.
  std::string take(const std::string& name);

 private:
  std::set<std::string> taken_;
};

}  // namespace sheen
