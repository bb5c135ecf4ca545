// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/scene/memory_warning.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/errors.h"
#include "reconstructor/models/surface_light_field/memory_account.h"
#include "tests/support/expect_error.h"

namespace sheen {
namespace {

using ::testing::HasSubstr;

constexpr double kGB = 1e9;

TEST(MemoryNeed, GrowsWithTheMeshAndWithWhatIsAsked) {
  const MemoryNeed small = memory_need(12'000, {}), large = memory_need(120'000, {});
  EXPECT_LT(small.least, small.most);
  EXPECT_NEAR(large.least / small.least, 10, 1e-6);
  EXPECT_NEAR(large.most / small.most, 10, 1e-6);
  SurfaceLightFieldOptions fine, few;
  fine.surface_map = 16;
  few.patch.factor.max_rank = 4;
  EXPECT_GT(memory_need(12'000, fine).most, 2 * small.most);
  EXPECT_LT(memory_need(12'000, few).most, small.most);
}

TEST(MemoryNeed, IsToldWithTheFiguresBeforeTheWork) {
  const MachineMemory machine{24 * kGB, 20 * kGB};
  EXPECT_EQ(memory_warning("m.ply", 12'000, memory_need(12'000, {}), machine), "");
  const std::string warning = memory_warning("m.ply", 3'000'000, memory_need(3'000'000, {}), machine);
  for (const char* word : {"m.ply: 3000000 triangles", "24 GB", "20 GB", "simplify the mesh to", "--memory"})
    EXPECT_THAT(warning, HasSubstr(word));
  expect_error<FileError>([&] { memory_warning("m.ply", 60'000'000, memory_need(60'000'000, {}), machine); },
                          {"m.ply", "60000000 triangles", "24 GB", "simplify"});
  EXPECT_EQ(memory_warning("m.ply", 60'000'000, memory_need(60'000'000, {}), {}), "") << "a system that does not say";
}

TEST(MemoryNeed, TheMachineSaysWhatItHas) {
  const MachineMemory machine = machine_memory();
  EXPECT_GT(machine.total, 1e8);
  EXPECT_LE(machine.available, machine.total);
}

}  // namespace
}  // namespace sheen
