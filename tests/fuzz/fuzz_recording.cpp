#include "engine/base/error.hpp"
#include "engine/base/hash.hpp"
#include "server/session/recording.hpp"

#include <cstdint>
#include <cstring>
#include <memory>
#include <sstream>
#include <string>

/// Checksums are made right first: nothing would come through otherwise.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace tetfront;
    std::string bytes(reinterpret_cast<const char*>(data), size);
    for (std::size_t at = 16; at + 24 <= bytes.size();) {
        std::uint32_t kind = 0;
        std::uint64_t length = 0;
        std::memcpy(&kind, bytes.data() + at, 4);
        std::memcpy(&length, bytes.data() + at + 8, 8);
        if (length > bytes.size() - at - 24) break;
        const std::string_view payload(bytes.data() + at + 24, length);
        const std::uint64_t sum = Hash().add(kind).add(length).add(payload).value();
        std::memcpy(bytes.data() + at + 16, &sum, 8);
        at += 24 + length;
    }
    try {
        Recording recording(std::make_unique<std::istringstream>(std::move(bytes)), "fuzz");
        for (std::size_t i = recording.frame_count(); i-- > 0;) static_cast<void>(recording.frame(i));
    } catch (const InputError&) {
        return 0;
    }
    return 0;
}
