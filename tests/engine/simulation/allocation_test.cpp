// A step on a front that does not change takes nothing from the heap. This program's operator new counts; it hands on to
// malloc, so that sanitizers see every block as usual.
#include <atomic>
#include <cstdlib>
#include <new>

#include <gtest/gtest.h>

#include "engine/simulation/simulation.hpp"
#include "tests/support/box_scene.hpp"

namespace {

std::atomic<long> allocations{0};

void* counted(std::size_t size, std::size_t alignment) {
    ++allocations;
    void* p = alignment <= alignof(std::max_align_t) ? std::malloc(size) : std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
    if (p == nullptr) throw std::bad_alloc();
    return p;
}

}  // namespace

void* operator new(std::size_t size) { return counted(size, 1); }
void* operator new(std::size_t size, std::align_val_t alignment) { return counted(size, static_cast<std::size_t>(alignment)); }
void operator delete(void* p) noexcept { std::free(p); }
void operator delete(void* p, std::size_t) noexcept { std::free(p); }
void operator delete(void* p, std::align_val_t) noexcept { std::free(p); }
void operator delete(void* p, std::size_t, std::align_val_t) noexcept { std::free(p); }

namespace tetfront {
namespace {

TEST(Allocations, AreCounted) {
    const long before = allocations;
    const std::vector<int> v(100);
    EXPECT_EQ(allocations - before, 1);
    EXPECT_EQ(v.size(), 100U);
}

class AllocationsOfOrder : public ::testing::TestWithParam<std::tuple<int, StrainMeasure>> {};
INSTANTIATE_TEST_SUITE_P(Orders, AllocationsOfOrder,
                         ::testing::Combine(::testing::Values(1, 2), ::testing::Values(StrainMeasure::corotated, StrainMeasure::green)));

TEST_P(AllocationsOfOrder, NoneInAStepOnASteadyFront) {
    Scene scene = box_scene();
    scene.levels = 2;
    scene.gravity = {0, 0, -1};
    scene.front.order = std::get<0>(GetParam());
    scene.solver.strain = std::get<1>(GetParam());
    Simulation simulation(build_model(scene));
    simulation.begin_pull(1, {}, {4, 0.5, 1.2});
    for (int i = 0; i < 200; ++i) (void)simulation.step();
    int steady = 0;
    for (int i = 0; i < 60; ++i) {
        const long before = allocations;
        const StepReport report = simulation.step();
        const long taken = allocations - before;
        if (report.splits + report.merges > 0) continue;
        ++steady;
        EXPECT_LE(taken, 1) << "step " << i;  // the report's list of tets by level belongs to the caller
    }
    EXPECT_GT(steady, 20);
}

}  // namespace
}  // namespace tetfront
