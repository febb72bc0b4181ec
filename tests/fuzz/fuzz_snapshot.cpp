#include "engine/base/error.hpp"
#include "engine/base/hash.hpp"
#include "engine/simulation/snapshot.hpp"
#include "tests/support/scenes.hpp"

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <string>

/// The header is made right first: nothing would come through otherwise. What is accepted must be stepped on without harm,
/// what is refused must change nothing.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace tetfront;
    static const auto model = testing::snapshot_model();
    static const std::string valid = Simulation(model).snapshot();
    constexpr std::size_t header = 40;
    std::string bytes(reinterpret_cast<const char*>(data), size);
    if (bytes.size() > header) {
        const std::uint64_t length = bytes.size() - header;
        std::uint32_t version = 0;
        std::uint64_t identity = 0;
        std::memcpy(bytes.data(), valid.data(), 24);  // magic, version, model
        std::memcpy(&version, valid.data() + 8, sizeof version);
        std::memcpy(&identity, valid.data() + 16, sizeof identity);
        const std::uint64_t sum = Hash().add(version).add(identity).add(std::string_view(bytes).substr(header)).value();
        std::memcpy(bytes.data() + 24, &sum, sizeof sum);
        std::memcpy(bytes.data() + 32, &length, sizeof length);
    }
    static Simulation simulation(model);
    const std::string before = simulation.snapshot();
    try {
        simulation.restore(bytes, "fuzz");
    } catch (const InputError&) {
        if (simulation.snapshot() != before) std::abort();
        return 0;
    }
    simulation.front().validate();
    simulation.step();
    for (const Vec3& x : simulation.all_positions())
        if (!x.allFinite()) std::abort();
    simulation.reset();
    return 0;
}
