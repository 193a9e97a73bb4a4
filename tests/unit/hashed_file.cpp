#include "core/hashed_file.h"

#include "support/shared_data.h"
#include "volcaustic/error.h"

#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <string>

namespace volcaustic::test {
namespace {

std::uint64_t digestOf(const std::string& text) {
  XxHash64 hash;
  hash.add(text.data(), text.size());
  return hash.digest();
}

// Values that the xxHash library gives with seed 0.
TEST(XxHash64, GivesTheDigestsOfTheLibrary) {
  EXPECT_EQ(digestOf(""), 0xEF46DB3751D8E999u);
  EXPECT_EQ(digestOf("a"), 0xD24EC4F1A98C6E5Bu);
  EXPECT_EQ(digestOf("abc"), 0x44BC2CF5AD770999u);
}

TEST(XxHash64, DoesNotKnowTheParts) {
  std::string text;
  for (int i = 0; i < 1000; ++i) text += static_cast<char>(i * i % 251);
  for (const std::size_t part : {1, 7, 31, 32, 33, 64, 500}) {
    XxHash64 hash;
    for (std::size_t at = 0; at < text.size(); at += part) hash.add(text.data() + at, std::min(part, text.size() - at));
    EXPECT_EQ(hash.digest(), digestOf(text)) << part;
  }
}

TEST(HashedFile, PatchesWithoutHashingThem) {
  const TemporaryFolder folder;
  std::ofstream(folder / "a").put('x');
  const std::string head = "head ----", body(200'000, 'b'), tail = "tail";
  std::uint64_t digest = 0;
  {
    HashedFile file(folder / "a");
    std::ostream out(&file);
    out << head;
    EXPECT_EQ(out.tellp(), 9);
    out << body;
    out.seekp(5);
    out << "1234";
    out.seekp(0, std::ios::end);
    out << tail;
    EXPECT_EQ(out.tellp(), static_cast<std::streamoff>(head.size() + body.size() + tail.size()));
    out.flush();
    EXPECT_TRUE(out.good());
    digest = file.digest();
  }
  std::ifstream in(folder / "a", std::ios::binary);
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(in), {}), "head 1234" + body + tail);
  EXPECT_EQ(digest, digestOf(head + body + tail));
}

TEST(HashedFile, TellsWhatCannotBeWritten) {
  HashedFile full("/dev/full");
  std::ostream out(&full);
  out << "x" << std::flush;
  EXPECT_FALSE(out.good());
  EXPECT_THROW(HashedFile("/nowhere/at/all"), Error);
}

} // namespace
} // namespace volcaustic::test
