# cmake -DREADME=... -DSOURCE=... -P check_readme.cmake: the README's example is the program that the tests build.
file(READ ${README} readme)
file(READ ${SOURCE} source)
string(FIND "${readme}" "```cpp\n${source}```" at)
if(at EQUAL -1)
  message(FATAL_ERROR "${README} does not hold ${SOURCE} word for word in a cpp block")
endif()
