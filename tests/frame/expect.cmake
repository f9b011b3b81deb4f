# Included by tests of the checks: runs the check ${SCRIPT} on the made-up tree in ${WORK_DIR}.
function(expect expected_result expected_message)
  execute_process(COMMAND ${CMAKE_COMMAND} -DSOURCE_DIR=${WORK_DIR} -P ${SCRIPT}
    RESULT_VARIABLE result ERROR_VARIABLE message OUTPUT_QUIET)
  if(NOT result EQUAL expected_result OR NOT message MATCHES "${expected_message}")
    message(FATAL_ERROR "expected ${expected_result} and \"${expected_message}\", got ${result} and:\n${message}")
  endif()
endfunction()
