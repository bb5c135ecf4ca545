// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/light_field_file/resolution_coding.h"

#include "reconstructor/light_field_file/resolution_coder.h"

namespace sheen {

using namespace resolution_coder;

std::vector<std::uint8_t> decode_resolutions(const GridMesh& mesh, std::string_view bytes) {
  Rule rule;
  if (bytes.size() < kRuleBytes) throw std::runtime_error("is cut short");
  std::memcpy(&rule.samples_per_step, bytes.data(), sizeof rule.samples_per_step);
  rule.smallest = static_cast<std::uint8_t>(bytes[kRuleBytes - 2]);
  rule.largest = static_cast<std::uint8_t>(bytes[kRuleBytes - 1]);
  if (rule.samples_per_step > kMostRate || rule.smallest < kSmallest)
    throw std::runtime_error("holds samples per length that cannot be");
  bytes.remove_prefix(kRuleBytes);
  BitModel bits(kContexts * kSignedContexts);
  ContextDecoder coder(bits, bytes);
  std::vector<std::uint8_t> resolutions(mesh.triangles.size());
  code_resolutions(coder, longest_edges(mesh), rule, resolutions);
  return resolutions;
}

}  // namespace sheen
