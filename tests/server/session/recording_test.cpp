// Recordings: what goes in comes out, whatever was cut off or damaged later.

#include "server/session/recording.hpp"

#include "engine/base/error.hpp"
#include "engine/base/hash.hpp"
#include "tests/support/blob_frame.hpp"
#include "tests/support/temporary_folder.hpp"

#include <cmath>
#include <csignal>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>
#include <sstream>

#include <gtest/gtest.h>
#include <sys/resource.h>

namespace tetfront {
namespace {

std::string read_all(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

/// Frame k: the lump k centimetres higher, with a front that changes after every second one.
std::shared_ptr<Frame> moment(int k) {
    static const std::shared_ptr<Frame> base = [] {
        auto lump = blob_frame(12);
        auto topology = std::make_shared<FrameTopology>(*lump->topology);
        lump->front_positions.resize(114);  // the cage
        topology->pieces = {{0, 1, 2, 3}, {3, 4, 5, 113}};
        topology->piece_level = {0, 2}, topology->piece_young = {1e4F, 2.5e5F};
        lump->topology = topology;
        return lump;
    }();
    static std::vector<std::shared_ptr<FrameTopology>> topologies;
    while (topologies.size() <= static_cast<std::size_t>(k / 2)) {
        topologies.push_back(std::make_shared<FrameTopology>(*base->topology));
        topologies.back()->epoch = static_cast<std::uint32_t>(topologies.size());
        topologies.back()->surface_level[0] = static_cast<std::uint8_t>(topologies.size() % 3);
    }
    auto frame = std::make_shared<Frame>(*base);
    frame->topology = topologies[static_cast<std::size_t>(k / 2)];
    for (auto& p : frame->surface) p[2] += 0.01F * static_cast<float>(k);
    frame->field = Field::stress;
    for (std::size_t i = 0; i < frame->surface.size(); ++i)
        frame->field_values.push_back(static_cast<float>(i) * static_cast<float>(k + 1));
    frame->front_values.assign(frame->front_positions.size(), 0.0F);
    frame->front_values[5] = 3;
    frame->pulls = {{{1, 2, 3}, {4, 5, 6}, 7}};
    frame->forces = {{{3, 2, 1}, {0, 0, -9}}};
    frame->status.time = k / 30.0;
    frame->status.step = static_cast<std::uint64_t>(2 * k);
    frame->status.warning = "mind the gap";
    return frame;
}

RecordingInfo info() {
    RecordingInfo info;
    info.name = "lump", info.title = "A \"lump\"", info.software = "test";
    info.view.colouring = Colouring::stress;
    info.view.cut = CutPlane{{0, 0, 0.4}, {0, 1, 0}};
    info.floor = -0.25, info.fps = 30, info.field = Field::stress;
    return info;
}

void write(const std::filesystem::path& file, int frames) {
    RecordingWriter writer(file, info(), *moment(0)->model);
    for (int k = 0; k < frames; ++k) writer.add(*moment(k));
    writer.finish();
}

Recording from_bytes(std::string bytes) { return {std::make_unique<std::istringstream>(std::move(bytes)), "bytes"}; }

TEST(Recording, GivesBackWhatWentIn) {
    const TemporaryFolder folder;
    const auto file = folder.path() / "run.tfr";
    write(file, 7);
    EXPECT_TRUE(is_recording(file));
    Recording run(file);
    EXPECT_TRUE(run.complete());
    ASSERT_EQ(run.frame_count(), 7U);
    EXPECT_EQ(run.info().title, "A \"lump\"");
    EXPECT_EQ(run.info().view, info().view);
    EXPECT_EQ(run.info().floor, -0.25);
    EXPECT_EQ(run.model()->triangles, moment(0)->model->triangles);
    EXPECT_EQ(run.model()->young, moment(0)->model->young);
    EXPECT_EQ(run.field_high(), static_cast<double>(field_high(moment(6)->field_values)));
    EXPECT_NEAR(run.field_high(), 0.98 * static_cast<double>(moment(6)->field_values.back()), 0.02 * run.field_high());
    for (const int k : {6, 0, 3, 2, 5, 1, 4}) {  // in any order
        const auto seen = run.frame(static_cast<std::size_t>(k));
        const auto made = moment(k);
        EXPECT_EQ(seen->model, run.model());
        EXPECT_EQ(seen->topology->edges, made->topology->edges);
        EXPECT_EQ(seen->topology->edge_level, made->topology->edge_level);
        EXPECT_EQ(seen->topology->surface_level, made->topology->surface_level);
        EXPECT_EQ(seen->topology->tets_by_level, made->topology->tets_by_level);
        EXPECT_EQ(seen->topology->pieces, made->topology->pieces);
        EXPECT_EQ(seen->topology->piece_level, made->topology->piece_level);
        EXPECT_EQ(seen->topology->piece_young, made->topology->piece_young);
        EXPECT_EQ(seen->topology->epoch, made->topology->epoch);
        EXPECT_EQ(seen->status.time, made->status.time);
        EXPECT_EQ(seen->status.step, made->status.step);
        EXPECT_EQ(seen->status.warning, "mind the gap");
        ASSERT_EQ(seen->pulls.size(), 1U);
        EXPECT_EQ(seen->pulls[0].to[1], 5);
        ASSERT_EQ(seen->forces.size(), 1U);
        EXPECT_EQ(seen->forces[0].at[0], 3);
        EXPECT_EQ(seen->forces[0].value[2], -9);
        ASSERT_EQ(seen->surface.size(), made->surface.size());
        for (std::size_t i = 0; i < made->surface.size(); ++i)
            for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(seen->surface[i][c], made->surface[i][c], 1e-6);
        for (std::size_t i = 0; i < made->front_positions.size(); ++i)
            for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(seen->front_positions[i][c], made->front_positions[i][c], 1e-6);
        ASSERT_EQ(seen->front_values.size(), made->front_values.size());
        EXPECT_NEAR(seen->front_values[5], 3, made->field_values.back() / 65535);
        EXPECT_EQ(seen->front_values[6], 0);
        for (std::size_t i = 0; i < made->surface.size(); ++i)
            EXPECT_NEAR(seen->field_values[i], made->field_values[i], made->field_values.back() / 65535);
    }
    EXPECT_EQ(run.frame(2)->topology, run.frame(3)->topology) << "shared, so that colours are not sent anew";
}

TEST(Recording, KeepsEventsBetweenFrames) {
    const TemporaryFolder folder;
    const auto file = folder.path() / "run.tfr";
    const std::string gravity = R"({"command":"gravity","value":[0,0,-1.62]})";
    {
        RecordingWriter writer(file, info(), *moment(0)->model);
        writer.add(*moment(0));
        writer.add(RecordedEvent{0.02, gravity});
        writer.add(RecordedEvent{0.03, "{}"});
        writer.add(*moment(1));
    }
    Recording run(file);
    ASSERT_EQ(run.events().size(), 2U);
    EXPECT_EQ(run.events()[0].time, 0.02);
    EXPECT_EQ(run.events()[0].json, gravity);
    EXPECT_EQ(run.frame_count(), 2U);
    EXPECT_EQ(run.frame(1)->status.time, moment(1)->status.time);
}

TEST(Recording, SameFramesSameBytesAndFewOfThem) {
    const TemporaryFolder folder;
    write(folder.path() / "a", 20), write(folder.path() / "b", 20);
    EXPECT_EQ(read_all(folder.path() / "a"), read_all(folder.path() / "b"));
    write(folder.path() / "c", 1);
    const auto each = (std::filesystem::file_size(folder.path() / "a") - std::filesystem::file_size(folder.path() / "c")) / 19;
    EXPECT_LT(each, 10 * (moment(0)->surface.size() + moment(0)->front_positions.size()))
        << "three floats and a field are 16 bytes a vertex, changes of the front apart";
}

TEST(Recording, IsReadableHoweverShortItWasCut) {
    const TemporaryFolder folder;
    write(folder.path() / "run.tfr", 5);
    const std::string bytes = read_all(folder.path() / "run.tfr");
    std::size_t most = 0;
    for (std::size_t length = 0; length < bytes.size(); length += 1 + length / 97) {
        try {
            Recording run = from_bytes(bytes.substr(0, length));
            EXPECT_FALSE(run.complete()) << length;
            EXPECT_GE(run.frame_count(), most) << "more bytes, not fewer frames";
            most = run.frame_count();
            EXPECT_EQ(run.frame(most - 1)->status.step, 2 * (most - 1));
        } catch (const InputError& error) {
            EXPECT_EQ(most, 0U) << length << ": " << error.what();
        }
    }
    EXPECT_GE(most, 4U);
    Recording without_end = from_bytes(bytes.substr(0, bytes.size() - 24));
    EXPECT_EQ(without_end.frame_count(), 5U) << "the process died before finish()";
}

TEST(Recording, DamageEndsItWhereItIs) {
    const TemporaryFolder folder;
    write(folder.path() / "run.tfr", 5);
    const std::string bytes = read_all(folder.path() / "run.tfr");
    std::size_t lost = 0, refused = 0;
    for (std::size_t at = 0; at < bytes.size(); at += 37) {
        std::string damaged = bytes;
        damaged[at] = static_cast<char>(damaged[at] ^ 0x10);
        try {
            Recording run = from_bytes(damaged);
            lost += run.frame_count() < 5 || !run.complete();
            for (std::size_t i = 0; i < run.frame_count(); ++i) EXPECT_EQ(run.frame(i)->status.step, 2 * i);
        } catch (const InputError&) {
            ++refused;  // in the header or before the first frame
        }
    }
    EXPECT_EQ(lost + refused, (bytes.size() + 36) / 37) << "every flipped bit is noticed";
}

TEST(Recording, FullDiskLeavesWholeFrames) {
    const TemporaryFolder folder;
    const auto file = folder.path() / "run.tfr";
    write(file, 4);
    const auto size = std::filesystem::file_size(file);
    rlimit before{};
    ::getrlimit(RLIMIT_FSIZE, &before);
    const auto handler = std::signal(SIGXFSZ, SIG_IGN);
    const rlimit small{size + 100, before.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &small);
    EXPECT_THROW(write(file, 100), OutputError);
    ::setrlimit(RLIMIT_FSIZE, &before);
    std::signal(SIGXFSZ, handler);
    Recording run(file);
    EXPECT_EQ(run.frame_count(), 4U);
    EXPECT_FALSE(run.complete());
    EXPECT_THROW(RecordingWriter(folder.path() / "missing" / "run.tfr", info(), *moment(0)->model), OutputError);
    EXPECT_THROW(write("/dev/full", 1), OutputError);
}

TEST(Recording, RefusesOtherFiles) {
    const TemporaryFolder folder;
    for (const std::string& bytes : {std::string(), std::string("tetfront"), std::string("{}"), std::string(100, 'x')}) {
        EXPECT_THROW(Recording(folder.write("other", bytes)), InputError);
        EXPECT_THROW(from_bytes(bytes), InputError);
    }
    EXPECT_FALSE(is_recording(folder.write("other", "{}")));
    EXPECT_THROW(Recording(folder.path() / "missing"), InputError);
    EXPECT_THROW(Recording(folder.path()), InputError);
    write(folder.path() / "run.tfr", 1);
    std::string newer = read_all(folder.path() / "run.tfr");
    newer[8] = 9;
    try {
        from_bytes(newer);
        ADD_FAILURE() << "version 9 was read";
    } catch (const InputError& error) {
        EXPECT_NE(std::string(error.what()).find("version 9"), std::string::npos) << error.what();
    }
}

/// The recording's bytes with one 4-byte word of a chunk's payload replaced, and the checksum to match.
std::string planted(std::string bytes, std::uint32_t wanted, std::size_t offset, std::uint32_t word) {
    for (std::size_t at = 16; at + 24 <= bytes.size();) {
        std::uint32_t kind = 0;
        std::uint64_t size = 0;
        std::memcpy(&kind, bytes.data() + at, 4);
        std::memcpy(&size, bytes.data() + at + 8, 8);
        if (kind == wanted && offset + 4 <= size) {
            std::memcpy(bytes.data() + at + 24 + offset, &word, 4);
            const std::uint64_t sum = Hash().add(kind).add(size).add(std::string_view(bytes).substr(at + 24, size)).value();
            std::memcpy(bytes.data() + at + 16, &sum, 8);
            return bytes;
        }
        at += 24 + size;
    }
    ADD_FAILURE() << "no such chunk";
    return bytes;
}

TEST(Recording, HostileContentsAreRefused) {
    const TemporaryFolder folder;
    write(folder.path() / "run.tfr", 2);
    const std::string bytes = read_all(folder.path() / "run.tfr");
    const auto use = [](const std::string& all) {
        Recording run = from_bytes(all);
        for (std::size_t i = 0; i < run.frame_count(); ++i) EXPECT_NE(run.frame(i), nullptr);
    };
    EXPECT_NO_THROW(use(planted(bytes, 3, 0, 77))) << "an epoch may be any number";
    EXPECT_THROW(use(planted(bytes, 2, 0, 3)), InputError) << "up axis";
    EXPECT_THROW(use(planted(bytes, 2, 4, 4000)), InputError) << "depth";
    EXPECT_THROW(use(planted(bytes, 2, 16, 0x7FC00000)), InputError) << "box, not a number";
    EXPECT_THROW(use(planted(bytes, 2, 40, 0xFFFFFFFF)), InputError) << "number of moduli";
    EXPECT_THROW(use(planted(bytes, 2, 44, 0xFFFFFFFF)), InputError) << "bytes of moduli";
    EXPECT_THROW(use(planted(bytes, 3, 4, 2)), InputError) << "edges beyond the front";
    EXPECT_THROW(use(planted(bytes, 3, 8, 0xFFFFFFFF)), InputError) << "number of edges";
    EXPECT_THROW(use(planted(bytes, 4, 4, 0x7FF80000)), InputError) << "time, not a number";
    EXPECT_THROW(use(planted(bytes, 4, 8, 0xBF800000)), InputError) << "negative largest value";
}

TEST(Recording, KeepsWhatIsNotFinite) {
    const TemporaryFolder folder;
    auto frame = moment(0);
    frame->surface[3] = {std::numeric_limits<float>::quiet_NaN(), 1e30F, -std::numeric_limits<float>::infinity()};
    frame->field_values[4] = std::numeric_limits<float>::quiet_NaN();
    RecordingWriter writer(folder.path() / "run.tfr", info(), *frame->model);
    writer.add(*frame);
    writer.finish();
    const auto seen = Recording(folder.path() / "run.tfr").frame(0);
    EXPECT_TRUE(std::isnan(seen->surface[3][0]));
    EXPECT_GT(seen->surface[3][1], 1000.0F) << "far away stays far away";
    EXPECT_LT(seen->surface[3][2], -1000.0F);
    EXPECT_EQ(seen->field_values[4], 0);
    EXPECT_NEAR(seen->surface[5][0], frame->surface[5][0], 1e-6);
}

}  // namespace
}  // namespace tetfront
