// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/commands/light_check.h"

#include "common/base/errors.h"

namespace sheen {

void require_light_kind(const ModelSnapshot& snapshot, std::span<const LitView> lights,
                        const std::filesystem::path& model, const std::filesystem::path& list) {
  const LightKind known = snapshot.light_kind();
  if (known == LightKind::kFixed)
    throw ConfigError(model.string() + " is a model of one fixed light: it cannot be lit by " + list.string());
  if (lights.front().light.kind == known) return;
  if (known == LightKind::kPoint)
    throw ConfigError(
        list.string() + " has directions of far lights, but " + model.string() +
        " was built from positions; of places on a dome of 1 m radius the list's first line has to say \"" +
        std::to_string(lights.size()) + " positions\"");
  throw ConfigError(list.string() + " has positions of near lights, but " + model.string() +
                    " was built from directions");
}

}  // namespace sheen
