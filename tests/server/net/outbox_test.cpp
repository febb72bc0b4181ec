#include "server/net/outbox.hpp"

#include <vector>

#include <gtest/gtest.h>

namespace tetfront {
namespace {

std::shared_ptr<const Moment> moment(std::uint16_t generation, std::uint32_t epoch, int sequence) {
    return std::make_shared<Moment>(Moment{generation, epoch, share("M" + std::to_string(generation)),
                                           share("T" + std::to_string(epoch)), share("F" + std::to_string(sequence))});
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
    outbox.set_state(share("state"));
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
    outbox.set_state(share("s1"));
    EXPECT_EQ(next(outbox), "-");
    outbox.show(moment(1, 1, 1));
    EXPECT_EQ(drain(outbox), (Messages{"M1", "T1", "F1", "s1"}));
    outbox.show(moment(1, 1, 2));
    outbox.set_state(share("s2"));
    outbox.set_state(share("s3"));
    EXPECT_EQ(drain(outbox), (Messages{"s3", "F2"}));
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

}  // namespace
}  // namespace tetfront
