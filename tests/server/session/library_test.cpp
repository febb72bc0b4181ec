#include "server/session/library.hpp"

#include "tests/support/box_scene.hpp"
#include "tests/support/temporary_folder.hpp"

#include <string>

#include <gtest/gtest.h>

namespace tetfront {
namespace {

std::string scene(const std::string& title) {
    std::string text = box_scene_text;
    return text.replace(text.find("A beam"), 6, title);
}
std::string titles(const Library& library) {
    std::string all;
    for (const auto& entry : library.scenes()) all += entry.name + "=" + entry.title + " ";
    return all;
}

TEST(Library, ScenesAreReadAgainOnlyWhenTheirFilesHaveChanged) {
    const TemporaryFolder folder;
    const auto a = folder.write("a.json", scene("First"));
    folder.write("b.json", "[]");
    const Library library(folder.path(), {});
    EXPECT_EQ(titles(library), "a=First ");
    EXPECT_TRUE(library.scene_file("b")) << "it is not read for that";
    EXPECT_FALSE(library.scene_file("c"));

    const auto written = std::filesystem::last_write_time(a);
    folder.write("a.json", scene("Other"));
    std::filesystem::last_write_time(a, written);
    EXPECT_EQ(titles(library), "a=First ") << "nothing says that it has changed, so it was not read";
    std::filesystem::last_write_time(a, written + std::chrono::seconds(1));
    EXPECT_EQ(titles(Library(library)), "a=Other ");
    folder.write("b.json", scene("Now a scene"));
    EXPECT_EQ(titles(library), "a=Other b=Now a scene ");
    std::filesystem::remove(a);
    EXPECT_EQ(titles(library), "b=Now a scene ");
}

TEST(Library, FoldersAreNobodysBusiness) {
    const Library library("/srv/scenes", "/var/lib/tetfront");
    EXPECT_EQ(library.without_folders("/var/lib/tetfront/recordings/run.tfr: cannot be written"), "run.tfr: cannot be written");
    EXPECT_EQ(library.without_folders("/var/lib/tetfront/states: cannot be made"), "states: cannot be made");
    EXPECT_EQ(library.without_folders("of /srv/scenes/a.json and /srv/scenes/b.json"), "of a.json and b.json");
    EXPECT_EQ(Library("/srv", "/srv/data").without_folders("/srv/data/recordings/run.tfr"), "run.tfr");
    EXPECT_EQ(Library().without_folders("a/b"), "a/b");
}

}  // namespace
}  // namespace tetfront
