# Exact p of Kruskal-Wallis tests by dealing the scores in every possible way, each with H of kruskal.test's formula:
# writes r_output.csv. Run once, in this folder: Rscript reference.R (R 4.2.2, base R alone)
options(warn = 2)
deals <- function(left, sizes) {
  if (length(sizes) == 1) return(list(list(left)))
  own <- combn(length(left), sizes[1], simplify = FALSE)
  unlist(lapply(own, function(i) lapply(deals(left[-i], sizes[-1]), function(rest) {
    c(list(left[i]), rest)
  })), recursive = FALSE)
}
exact <- function(groups) {
  scores <- unlist(groups)
  ranks <- rank(scores)
  sizes <- lengths(groups)
  spread <- sum((ranks - mean(ranks))^2)
  h <- function(parts) {
    (length(ranks) - 1) *
      sum(sapply(parts, function(i) length(i) * (mean(ranks[i]) - mean(ranks))^2)) / spread
  }
  ends <- cumsum(sizes)
  observed <- h(Map(seq, ends - sizes + 1, ends))
  stopifnot(abs(observed - kruskal.test(groups)$statistic) < 1e-9)
  every <- sapply(deals(seq_along(scores), sizes), h)
  c(h = observed, p = mean(every > observed - 1e-9), ways = length(every))
}
data <- list(
  distinct = list(c(1, 5, 2), c(4, 8, 9), c(7, 6, 3)),
  tied = list(c(0, 0, 1, 2), c(2, 3, 3), c(1, 5, 5)),
  uneven = list(c(1, 2, 2, 4, 1), c(3, 6, 6, 2), c(7, 5, 4)),
  four = list(c(0, 1), c(1, 3), c(2, 2), c(5, 4)),
  lonely = list(c(9), c(1, 4, 2, 2), c(3, 6, 4)),
  two = list(c(1, 4, 2, 2), c(3, 6, 4, 7)),
  five = list(c(1, 1), c(2, 0), c(3), c(4, 2), c(6))
)
found <- do.call(rbind, lapply(names(data), function(name) {
  values <- exact(data[[name]])
  groups <- paste(sapply(data[[name]], paste, collapse = " "), collapse = "; ")
  data.frame(dataset = name, groups = groups, h = sprintf("%.17g", values["h"]),
             p = sprintf("%.17g", values["p"]), ways = values["ways"])
}))
write.csv(found, "r_output.csv", row.names = FALSE)
