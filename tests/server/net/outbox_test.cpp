#include "server/net/outbox.hpp"

#include <vector>

#include <gtest/gtest.h>

namespace tetfront {
namespace {

std::shared_ptr<const Moment> moment(std::uint16_t generation, std::uint32_t epoch, int sequence) {
    return std::make_shared<Moment>(Moment{generation, epoch, share("M" + std::to_string(generation)),
                                           share("T" + std::to_string(epoch)), static_cast<std::uint32_t>(sequence),
                                           [sequence](FrameKind) { return share("F" + std::to_string(sequence)); }});
}

std::string next(Outbox& outbox) {
    const auto message = outbox.next();
    return message ? *message->bytes : "-";
}

std::vector<std::string> drain(Outbox& outbox) {
    std::vector<std::string> all;
    while (const auto message = outbox.next()) all.push_back(*message->bytes);
    return all;
}

using Messages = std::vector<std::string>;

TEST(Outbox, NewcomerGetsHelloModelTopologyFrameState) {
    Outbox outbox;
    outbox.set(Outbox::Slot::state, share("state"));
    outbox.show(moment(1, 5, 9));
    ASSERT_TRUE(outbox.push("hello"));
    EXPECT_EQ(drain(outbox), (Messages{"hello", "M1", "T5", "F9", "state"}));
}

TEST(Outbox, SendsModelAndTopologyOnlyOnChange) {
    Outbox outbox;
    outbox.show(moment(1, 5, 1));
    drain(outbox);
    outbox.show(moment(1, 5, 2));
    EXPECT_EQ(drain(outbox), (Messages{"F2"}));
    outbox.show(moment(1, 6, 3));
    EXPECT_EQ(drain(outbox), (Messages{"T6", "F3"}));
    outbox.show(moment(2, 6, 4));
    EXPECT_EQ(drain(outbox), (Messages{"M2", "T6", "F4"}));
}

TEST(Outbox, LatestFrameWins) {
    Outbox outbox;
    for (int i = 0; i < 1000; ++i) outbox.show(moment(1, 1, i));
    EXPECT_EQ(drain(outbox), (Messages{"M1", "T1", "F999"}));
}

TEST(Outbox, SlowClientGetsFramesEvenWhenEveryFrameHasANewTopology) {
    Outbox outbox;
    std::vector<std::string> sent;
    for (int i = 0; i < 9; ++i) {  // a newer moment arrives after each message that was sent
        outbox.show(moment(1, static_cast<std::uint32_t>(i), i));
        sent.push_back(next(outbox));
    }
    EXPECT_EQ(sent, (Messages{"M1", "T0", "F0", "T3", "F3", "T5", "F5", "T7", "F7"}));
}

TEST(Outbox, NewestStateOvertakesFramesButNotTheFirst) {
    Outbox outbox;
    outbox.set(Outbox::Slot::state, share("s1"));
    EXPECT_EQ(next(outbox), "-");
    outbox.show(moment(1, 1, 1));
    EXPECT_EQ(drain(outbox), (Messages{"M1", "T1", "F1", "s1"}));
    outbox.show(moment(1, 1, 2));
    outbox.set(Outbox::Slot::state, share("s2"));
    outbox.set(Outbox::Slot::state, share("s3"));
    EXPECT_EQ(drain(outbox), (Messages{"s3", "F2"}));
}

TEST(Outbox, AClientThatAcknowledgesHasTwoFramesInFlight) {
    Outbox outbox;
    const auto show = [&](int sequence) { outbox.show(moment(1, 1, sequence)); };
    for (int i = 1; i <= 5; ++i) show(i), drain(outbox);
    EXPECT_EQ(outbox.statistics().in_flight, 0U) << "it has not acknowledged any yet";
    outbox.acknowledge(4);
    EXPECT_EQ(outbox.statistics().in_flight, 1U);
    show(6);
    EXPECT_EQ(drain(outbox), (Messages{"F6"}));
    show(7), show(8);
    EXPECT_EQ(drain(outbox), (Messages{}));
    EXPECT_EQ(outbox.statistics().in_flight, 2U);
    outbox.acknowledge(99);
    outbox.acknowledge(4);
    EXPECT_EQ(drain(outbox), (Messages{})) << "what is not in flight is ignored";
    outbox.acknowledge(5);
    EXPECT_EQ(drain(outbox), (Messages{"F8"}));
    EXPECT_EQ(outbox.statistics().sent, 7U);
    EXPECT_EQ(outbox.statistics().dropped, 1U);
}

TEST(Outbox, ASleepingClientStillGetsAnswersAndStates) {
    Outbox outbox;
    outbox.show(moment(1, 1, 1)), drain(outbox);
    outbox.acknowledge(1);
    for (int i = 2; i < 10; ++i) outbox.show(moment(1, 1, i)), drain(outbox);
    outbox.show(moment(1, 1, 10));
    outbox.set(Outbox::Slot::state, share("state"));
    ASSERT_TRUE(outbox.push("ok"));
    EXPECT_EQ(drain(outbox), (Messages{"ok", "state"}));
}

TEST(Outbox, MeasuresTheRoundTrip) {
    using namespace std::chrono_literals;
    Outbox outbox;
    const Outbox::Clock::time_point start{};
    outbox.show(moment(1, 1, 1));
    while (outbox.next(start)) {
    }
    EXPECT_FALSE(outbox.statistics().round_trip);
    outbox.acknowledge(1, start + 250ms);
    EXPECT_EQ(outbox.statistics().round_trip, 0.25);
}

TEST(Outbox, SendsTheKindOfFrameThatTheClientWants) {
    Outbox outbox;
    Moment kinds = *moment(1, 1, 1);
    kinds.frame = [](FrameKind kind) {
        return share((kind.field == Field::stress ? "stress" : "plain") + std::string(kind.compressed ? " compressed" : ""));
    };
    const auto present = std::make_shared<Moment>(kinds);
    outbox.show(present);
    EXPECT_EQ(drain(outbox), (Messages{"M1", "T1", "plain"}));
    outbox.set_kind({Field::stress, false});
    outbox.show(present);
    EXPECT_EQ(drain(outbox), (Messages{"stress"}));
    outbox.set_kind({Field::stress, true});
    outbox.show(present);
    EXPECT_EQ(drain(outbox), (Messages{"stress compressed"}));
}

TEST(Outbox, ANewHelloForgetsAllFromBeforeButAnswers) {
    Outbox outbox;
    outbox.show(moment(1, 1, 1)), drain(outbox);
    outbox.show(moment(1, 2, 2));
    EXPECT_EQ(next(outbox), "T2");
    outbox.set(Outbox::Slot::state, share("old"));
    ASSERT_TRUE(outbox.push("ok"));
    outbox.restart();
    ASSERT_TRUE(outbox.push("hello"));
    outbox.show(moment(2, 1, 3));
    EXPECT_EQ(drain(outbox), (Messages{"ok", "hello", "M2", "T1", "F3"}));
}

TEST(Outbox, AnswersAreOrderedAndBounded) {
    Outbox outbox;
    for (std::size_t i = 0; i < Outbox::max_controls; ++i) ASSERT_TRUE(outbox.push(std::to_string(i)));
    EXPECT_FALSE(outbox.push("one too many"));
    const auto all = drain(outbox);
    ASSERT_EQ(all.size(), Outbox::max_controls);
    for (std::size_t i = 0; i < all.size(); ++i) EXPECT_EQ(all[i], std::to_string(i));
    EXPECT_TRUE(outbox.push("room again"));
}

TEST(Outbox, LargeAnswersAreFewer) {
    Outbox outbox;
    const std::string large(Outbox::max_control_bytes / 4, 'x');
    ASSERT_TRUE(outbox.push(std::string(3 * Outbox::max_control_bytes, 'x'))) << "one may be of any size";
    EXPECT_FALSE(outbox.push("ok")) << "but nothing waits behind it";
    EXPECT_EQ(drain(outbox).size(), 1U);
    for (int i = 0; i < 5; ++i) ASSERT_TRUE(outbox.push(large));
    EXPECT_FALSE(outbox.push("ok"));
    EXPECT_EQ(drain(outbox).size(), 5U);
    EXPECT_TRUE(outbox.push("ok"));
}

}  // namespace
}  // namespace tetfront
