# A detector for `stiction bench detector`, in R without any package.
#
#   stiction bench detector 'Rscript detector.R' --suite v1-trial
#
# It reads a recording as JSON in each line of standard input, and writes an answer as JSON. The score is minus the kurtosis
# of the OP: -1.8 for a triangle, -3 for noise.

# The value of a text, and the numbers of a signal, in a line whose form is known.
text <- function(line, key) sub(paste0('.*"', key, '":"([^"]*)".*'), "\\1", line)
signal <- function(line, key) {
  found <- regmatches(line, regexpr(paste0('"', key, '":\\[[^]]*\\]'), line))
  if (length(found) == 0) return(NULL)
  inside <- sub("\\]$", "", sub("^[^[]*\\[", "", found))
  scan(text = inside, sep = ",", na.strings = "null", quiet = TRUE)
}

input <- file("stdin", "r")
while (length(line <- readLines(input, n = 1)) > 0) {
  op <- signal(line, "op")
  op <- op[!is.na(op)]
  second <- mean((op - mean(op))^2)
  if (second > 0) {
    score <- -mean((op - mean(op))^4) / second^2
    decision <- if (score > -1.9) "sticks" else "does not stick"
    cat(sprintf('{"id":"%s","score":%.17g,"decision":"%s"}\n', text(line, "id"), score, decision))
  } else {
    cat(sprintf('{"id":"%s","decision":"abstain"}\n', text(line, "id")))
  }
  flush(stdout())
}
