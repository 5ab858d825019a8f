# Writes SUITES, a file that ctest includes: one test for each suite of the gtest program PROGRAM.
execute_process(COMMAND ${PROGRAM} --gtest_list_tests OUTPUT_VARIABLE listed COMMAND_ERROR_IS_FATAL ANY)
string(REPLACE "\n" ";" lines "${listed}")
set(text "")
foreach(line IN LISTS lines)
  # Suites begin a line and end with a dot; a typed one is followed by its type.
  if(line MATCHES "^([A-Za-z0-9_/]+)\\.( *#.*)?$")
    set(suite ${CMAKE_MATCH_1})
    string(APPEND text "add_test([=[${suite}]=] [=[${PROGRAM}]=] [=[--gtest_filter=${suite}.*]=])\n"
                       "set_tests_properties([=[${suite}]=] PROPERTIES TIMEOUT 900)\n")
  endif()
endforeach()
file(WRITE ${SUITES} "${text}")
