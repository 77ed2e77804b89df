# Writes OUTPUT from TEMPLATE; configure_file leaves the file alone when its text would not change.
set(REVISION "unknown")
find_package(Git QUIET)
if(GIT_FOUND AND EXISTS ${SOURCE_DIR}/.git)
  execute_process(COMMAND ${GIT_EXECUTABLE} -C ${SOURCE_DIR} describe --always --dirty --abbrev=12 --exclude=*
    OUTPUT_VARIABLE answer OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failed)
  if(NOT failed AND answer)
    set(REVISION "${answer}")
  endif()
endif()
configure_file(${TEMPLATE} ${OUTPUT} @ONLY)
