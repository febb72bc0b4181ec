#include "server/session/scene_build.hpp"

#include "engine/base/error.hpp"
#include "engine/simulation/shape.hpp"

#include <string>
#include <utility>

namespace tetfront {

namespace {
struct Stopped {};  // thrown through build_model() by its progress callback

void check_size(const Scene& scene, const Shape& shape, std::size_t most_tets) {
    const std::size_t roots = shape.roots.corners.size(), tets = roots << (3 * scene.levels);
    if (tets > most_tets)
        throw InputError(scene.file.string(), "/levels",
                         "makes " + std::to_string(tets) + " tets of " + std::to_string(roots) + "; this server loads scenes of " +
                             std::to_string(most_tets) + " at most",
                         "use fewer levels or fewer root tets, or start the server with a larger --max-tets");
}
}  // namespace

SceneBuild::SceneBuild(std::function<Scene()> read, std::size_t most_tets, CacheSettings cache, Progress progress,
                       std::function<void()> done) {
    thread_ = std::thread([this, read = std::move(read), most_tets, cache = std::move(cache), progress = std::move(progress),
                           done = std::move(done)] {
        const Progress report = [&](const std::string& what, double fraction) {
            if (stopping_) throw Stopped{};
            if (progress) progress(what, fraction);
        };
        try {
            report("meshing", 0);
            const Scene scene = read();
            Shape shape = make_shape(scene);
            check_size(scene, shape, most_tets);
            model_ = build_model(scene, std::move(shape), report, cache);
        } catch (...) {
            error_ = std::current_exception();
        }
        finished_ = true;
        done();
    });
}

SceneBuild::~SceneBuild() {
    stopping_ = true;
    thread_.join();
}

std::shared_ptr<const Model> SceneBuild::take() {
    ENSURE(finished_, "the build goes on");
    if (error_) std::rethrow_exception(std::exchange(error_, nullptr));
    return std::move(model_);
}

}  // namespace tetfront
