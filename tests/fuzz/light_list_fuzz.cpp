// SPDX-License-Identifier: Apache-2.0
// Whatever a list of lights holds: lights that can be asked for, which stay the same when they are written and read
// again, or a FileError.
#include <cmath>
#include <set>
#include <string>

#include "common/base/errors.h"
#include "common/datasets/light_list.h"
#include "tests/fuzz/fuzz_input.h"

using namespace sheen;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const std::vector<LitView> views = parse_light_list("fuzz", {reinterpret_cast<const char*>(data), size});
    fuzz::demand(!views.empty(), "a list without lights");
    std::set<std::string> names;
    const LightKind kind = views.front().light.kind;
    for (const LitView& view : views) {
      fuzz::demand(!view.name.empty() && names.insert(view.name).second, "a name that is none, or stands there twice");
      fuzz::demand(view.light.kind == kind, "lights of two kinds");
      fuzz::demand(kind == LightKind::kDirectional || kind == LightKind::kPoint, "lights of no kind");
      const double length = view.light.position.norm();
      fuzz::demand(std::isfinite(length) && length > 0, "a light that is nowhere");
      fuzz::demand(kind == LightKind::kPoint || std::abs(length - 1) < 1e-9, "a direction of another length than 1");
    }
    const std::vector<LitView> again = parse_light_list("again", light_list_text(views));
    fuzz::demand(again.size() == views.size(), "lost lights");
    for (std::size_t i = 0; i < views.size(); ++i)
      fuzz::demand(
          again[i].name == views[i].name && again[i].light.kind == views[i].light.kind &&
              (again[i].light.position - views[i].light.position).norm() <= 1e-9 * views[i].light.position.norm(),
          "another light when read again");
  } catch (const FileError&) {
  }
  return 0;
}
