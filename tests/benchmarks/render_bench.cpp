// Speed of pictures at 1280x720 with 2x2 samples a pixel, by number of triangles: the whole picture, and the parts
// around it. Needs an otherwise idle machine.
//
//     build/release/tests/render_bench

#include "engine/base/parallel.hpp"
#include "server/render/geometry.hpp"
#include "server/render/png.hpp"
#include "server/render/renderer.hpp"
#include "tests/support/blob_frame.hpp"

#include <benchmark/benchmark.h>

namespace tetfront {
namespace {

// 4 r^2 triangles: 3.6k, 57.6k, 200k.
constexpr int small = 30, medium = 120, large = 224;

void set_triangles(benchmark::State& state, const Frame& frame) {
    state.counters["triangles"] = static_cast<double>(frame.model->triangles.size());
}

View full_view(const Frame& frame) { return make_view(ViewSpec{}, *frame.model, 1280, 720); }

void draw(benchmark::State& state, bool wireframe, int supersampling, bool legend) {
    const auto frame = blob_frame(static_cast<int>(state.range(0)));
    View view = full_view(*frame);
    view.wireframe = wireframe, view.supersampling = supersampling, view.legend = legend;
    static Renderer renderer;
    renderer.render(*frame, view, "Blob");  // compiles the shaders
    for (auto _ : state) benchmark::DoNotOptimize(renderer.render(*frame, view, "Blob"));
    set_triangles(state, *frame);
}

void picture(benchmark::State& state) { draw(state, false, 2, true); }
void picture_with_wireframe(benchmark::State& state) { draw(state, true, 2, true); }
void picture_without_supersampling(benchmark::State& state) { draw(state, false, 1, true); }
void picture_without_legend(benchmark::State& state) { draw(state, false, 2, false); }
BENCHMARK(picture)
    ->Arg(small)
    ->Arg(medium)
    ->Arg(large)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->MeasureProcessCPUTime();
BENCHMARK(picture_with_wireframe)->Arg(small)->Unit(benchmark::kMillisecond)->UseRealTime()->MeasureProcessCPUTime();
BENCHMARK(picture_without_supersampling)
    ->Arg(small)
    ->Arg(large)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->MeasureProcessCPUTime();
BENCHMARK(picture_without_legend)->Arg(small)->Unit(benchmark::kMillisecond)->UseRealTime()->MeasureProcessCPUTime();

void normals(benchmark::State& state) {
    const auto frame = blob_frame(static_cast<int>(state.range(0)));
    const VertexFaces faces(frame->model->triangles, frame->surface.size());
    std::vector<Point> out;
    for (auto _ : state) faces.normals(frame->surface, out);
    set_triangles(state, *frame);
}
BENCHMARK(normals)->Arg(small)->Arg(large)->Unit(benchmark::kMillisecond)->UseRealTime();

void encode(benchmark::State& state) {
    const auto frame = blob_frame(small);
    const Image image = Renderer().render(*frame, full_view(*frame), "Blob");
    std::size_t bytes = 0;
    for (auto _ : state) bytes = encode_png(image, {.level = static_cast<int>(state.range(0))}).size();
    state.counters["bytes"] = static_cast<double>(bytes);
}
BENCHMARK(encode)->Arg(1)->Arg(6)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace tetfront

BENCHMARK_MAIN();
