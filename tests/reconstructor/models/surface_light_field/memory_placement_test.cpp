// SPDX-License-Identifier: Apache-2.0
// The same images give the same model wherever the heap puts what belongs to it. A sum in wide instructions may begin
// at the first address that suits them: then its last digits are those of the allocator.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <new>

#include "tests/reconstructor/models/surface_light_field/light_field_checks.h"

namespace {

constexpr std::size_t kLine = 64;
std::atomic<std::size_t> shift_bytes{0};

/// Memory `shift_bytes` behind a multiple of 64; where it really begins stands before it.
void* shifted(std::size_t size) {
  auto* const whole = static_cast<std::byte*>(std::malloc(size + 3 * kLine));
  if (!whole) throw std::bad_alloc();
  const auto address = reinterpret_cast<std::uintptr_t>(whole) + sizeof(void*);
  std::byte* const memory =
      whole + sizeof(void*) + ((kLine - address % kLine) % kLine + shift_bytes.load(std::memory_order_relaxed));
  reinterpret_cast<void**>(memory)[-1] = whole;
  return memory;
}

void give_back(void* memory) noexcept {
  if (memory) std::free(static_cast<void**>(memory)[-1]);
}

}  // namespace

void* operator new(std::size_t size) {
  return shifted(size);
}
void* operator new[](std::size_t size) {
  return shifted(size);
}
void operator delete(void* memory) noexcept {
  give_back(memory);
}
void operator delete[](void* memory) noexcept {
  give_back(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  give_back(memory);
}
void operator delete[](void* memory, std::size_t) noexcept {
  give_back(memory);
}

namespace sheen {
namespace {

std::shared_ptr<const ModelSnapshot> model_of_ball(const SurfaceLightFieldOptions& options) {
  const Object object = sphere_object();
  const analytic::Scene scene{object.surface, analytic::two_terms(0.2)};
  SurfaceLightField model(object.mesh, options);
  ingest_all(model, captures(scene, analytic::eyes(24, 0.5, 0.3, 0.95)));
  model.finish();
  return model.snapshot();
}

class MemoryPlacement : public ::testing::Test {
 protected:
  ~MemoryPlacement() override { shift_bytes = 0; }

  static void expect_same_model_anywhere(const SurfaceLightFieldOptions& options) {
    shift_bytes = 0;
    const auto model = model_of_ball(options);
    for (const std::size_t shift : {16, 32, 48}) {
      shift_bytes = shift;
      SCOPED_TRACE("memory shifted by " + std::to_string(shift) + " bytes");
      expect_same_patches(*model, *model_of_ball(options));
    }
  }
};

TEST_F(MemoryPlacement, DefaultsGiveTheSameBits) {
  expect_same_model_anywhere(plain_options());
}

// Patches of small maps have many vertices: enough for wide instructions, also for those of 64 bytes.
TEST_F(MemoryPlacement, SmallMapsOfFewTermsGiveTheSameBits) {
  SurfaceLightFieldOptions options = plain_options();
  options.patch.factor.max_rank = 4;
  for (const int side : {2, 4}) {
    options.surface_map = side;
    expect_same_model_anywhere(options);
  }
}

}  // namespace
}  // namespace sheen
